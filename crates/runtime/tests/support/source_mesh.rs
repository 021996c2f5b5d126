//! A `render.glb` for tests.

/// A file of one primitive of triangles between vertices in their order; an attribute is its name, its floats per vertex and all of them.
pub fn file(attributes: &[(&str, usize, Vec<f32>)]) -> Vec<u8> {
    let mut bin = Vec::new();
    let (mut views, mut accessors, mut names) = (Vec::new(), Vec::new(), Vec::new());
    for (k, (name, width, values)) in attributes.iter().enumerate() {
        let (start, count) = (bin.len(), values.len() / width);
        bin.extend(values.iter().flat_map(|x| x.to_le_bytes()));
        views.push(format!(r#"{{"buffer":0,"byteOffset":{start},"byteLength":{}}}"#, bin.len() - start));
        let kind = if *width == 1 { "SCALAR".to_owned() } else { format!("VEC{width}") };
        accessors.push(format!(r#"{{"bufferView":{k},"componentType":5126,"count":{count},"type":"{kind}"}}"#));
        names.push(format!(r#""{name}":{k}"#));
    }
    let (views, accessors, names) = (views.join(","), accessors.join(","), names.join(","));
    let mut text = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{}}}],"bufferViews":[{views}],"accessors":[{accessors}],
        "meshes":[{{"primitives":[{{"attributes":{{{names}}}}}]}}]}}"#,
        bin.len()
    )
    .into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend(((28 + text.len() + bin.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &bin)] {
        out.extend((chunk.len() as u32).to_le_bytes());
        out.extend(kind);
        out.extend(chunk);
    }
    out
}
