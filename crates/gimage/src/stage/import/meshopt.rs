//! Views compressed with `EXT_meshopt_compression` or `KHR_meshopt_compression`.

use meshopt::{
    decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat, decode_index_buffer,
    decode_index_sequence, decode_vertex_buffer,
};

/// Properties of a view that the extension states.
pub(crate) struct Header<'a> {
    pub mode: &'a str,
    pub filter: &'a str,
    pub count: usize,
    pub stride: usize,
}

/// The decoded view, `count * stride` bytes, or what is wrong. The caller has checked `count * stride` against its budget.
pub(crate) fn decode(header: &Header, data: &[u8]) -> Result<Vec<u8>, String> {
    let Header { mode, filter, count, stride } = *header;
    if count == 0 {
        return Ok(Vec::new());
    }
    // The decoders reserve `count` elements before they look at the data: a stream has at least these many bytes.
    let least = match mode {
        "ATTRIBUTES" => count.div_ceil(256).saturating_mul(stride / 4),
        "TRIANGLES" => (count / 3).saturating_add(17),
        "INDICES" => count.saturating_add(5),
        _ => return Err(format!("unknown mode `{mode}`")),
    };
    if data.len() < least {
        return Err(format!("{} bytes cannot hold {count} elements", data.len()));
    }
    let damaged = |e: meshopt::Error| format!("the stream is damaged ({e})");
    let bytes = match (mode, stride) {
        ("ATTRIBUTES", 4..=256) if stride % 4 == 0 => vertices(data, count, stride).map_err(damaged)?,
        ("TRIANGLES", 2) if count % 3 == 0 => u16s(&decode_index_buffer(data, count).map_err(damaged)?),
        ("TRIANGLES", 4) if count % 3 == 0 => u32s(&decode_index_buffer(data, count).map_err(damaged)?),
        ("INDICES", 2) => u16s(&decode_index_sequence(data, count).map_err(damaged)?),
        ("INDICES", 4) => u32s(&decode_index_sequence(data, count).map_err(damaged)?),
        _ => return Err(format!("mode {mode} cannot have {count} elements of {stride} bytes")),
    };
    if filter != "NONE" && mode != "ATTRIBUTES" {
        return Err(format!("mode {mode} cannot have filter {filter}"));
    }
    match (filter, stride) {
        ("NONE", _) => Ok(bytes),
        ("OCTAHEDRAL", 4) => Ok(filtered(&bytes, |b| b[0] as i8, decode_filter_oct, |c| [c as u8])),
        ("OCTAHEDRAL", 8) => Ok(filtered(&bytes, i16_of, decode_filter_oct, i16::to_le_bytes)),
        ("QUATERNION", 8) => Ok(filtered(&bytes, i16_of, decode_filter_quat, i16::to_le_bytes)),
        ("COLOR", 4) => Ok(filtered(&bytes, |b| b[0], decode_filter_color, |c| [c])),
        ("COLOR", 8) => Ok(filtered(&bytes, u16::from_le_bytes, decode_filter_color, u16::to_le_bytes)),
        // Each word is decoded by itself, so a view is a run of single words.
        ("EXPONENTIAL", _) => {
            let words = bytes.chunks_exact(4).map(|b| [u32::from_le_bytes([b[0], b[1], b[2], b[3]])]);
            let mut words: Vec<[u32; 1]> = words.collect();
            decode_filter_exp(&mut words);
            Ok(words.iter().flat_map(|w| w[0].to_le_bytes()).collect())
        }
        _ => Err(format!("filter `{filter}` cannot have elements of {stride} bytes")),
    }
}

fn i16_of(b: [u8; 2]) -> i16 {
    i16::from_le_bytes(b)
}

/// Runs a filter that works on four components at a time.
fn filtered<C: Copy, const W: usize>(
    bytes: &[u8],
    read: impl Fn([u8; W]) -> C,
    filter: impl Fn(&mut [[C; 4]]),
    write: impl Fn(C) -> [u8; W],
) -> Vec<u8> {
    let component = |e: &[u8], k: usize| read(std::array::from_fn(|i| e[k * W + i]));
    let mut all: Vec<[C; 4]> = bytes.chunks_exact(4 * W).map(|e| std::array::from_fn(|k| component(e, k))).collect();
    filter(&mut all);
    all.iter().flatten().flat_map(|&c| write(c)).collect()
}

fn u16s(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn u32s(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// A vertex of `N` words; arrays have no default beyond 32.
#[derive(Clone)]
struct Words<const N: usize>([u32; N]);

impl<const N: usize> Default for Words<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

fn words<const N: usize>(data: &[u8], count: usize) -> meshopt::Result<Vec<u8>> {
    let all: Vec<Words<N>> = decode_vertex_buffer(data, count)?;
    Ok(all.iter().flat_map(|w| w.0).flat_map(u32::to_ne_bytes).collect())
}

/// The decoder takes the stride as the size of a type, so each stride is a type.
fn vertices(data: &[u8], count: usize, stride: usize) -> meshopt::Result<Vec<u8>> {
    macro_rules! by_stride {
        ($($n:literal)*) => { match stride / 4 { $($n => words::<$n>(data, count),)* _ => words::<64>(data, count) } };
    }
    by_stride!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 34 35 36 37 38 39
        40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63)
}
