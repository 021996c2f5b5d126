//! The files of an export. They wait beside their targets until the run is over.

use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use gimage::export::motion::{Dressing, GltfMotion, MotionWriter, Part, UsdMotion, check as check_frame};
use gimage::export::obj;
use gimage::reconstruct::Reconstruction;
use gimage_bundle::dir::{StagedFiles, check_beside};

use super::Kind;
use super::schedule::Schedule;
use crate::exit::Failure;
use crate::files::{check_file_target, check_parent};

/// The result of an export.
pub struct Written {
    /// The files, in order.
    pub files: Vec<String>,
    /// Of all files.
    pub bytes: u64,
}

/// Takes frames, and writes their files.
pub struct Sink {
    output: PathBuf,
    files: StagedFiles,
    form: Form,
}

enum Form {
    /// One file of all frames, whose bytes are collected in a temporary one.
    One { writer: Box<dyn MotionWriter>, temporary: BufWriter<File> },
    /// A file per frame.
    Sequence { names: Vec<String>, bytes: u64 },
}

/// Whether the files could be written: ask before the work is done.
pub fn check(kind: Kind, output: &Path, force: bool) -> Result<(), Failure> {
    name_of(output)?;
    if kind != Kind::Obj {
        return check_file_target(output, force);
    }
    check_parent(output)?;
    let older = older(output)?;
    match older.first() {
        Some(first) if !force => {
            let (folder, count) = (output.with_file_name(first), older.len());
            Err(Failure::refused(format!(
                "{}: it is there already, with {} other frames of that name; choose another name, or give --force to replace them",
                folder.display(),
                count - 1
            )))
        }
        _ => Ok(check_beside(output)?),
    }
}

impl Sink {
    /// For the frames of a schedule; a .glb has the materials of `dressing`.
    pub fn new(kind: Kind, output: &Path, schedule: &Schedule, dressing: Option<Dressing>) -> Result<Self, Failure> {
        let mut files = StagedFiles::beside(output)?;
        let stem = output.file_stem().unwrap_or_default().to_string_lossy();
        let writer: Option<Box<dyn MotionWriter>> = match kind {
            Kind::Glb(shown, compression) => {
                let writer = GltfMotion::new(shown, schedule.kept()).compressed(compression)?;
                Some(Box::new(match dressing {
                    Some(dressing) => writer.dressed(dressing),
                    None => writer,
                }))
            }
            Kind::Usd => Some(Box::new(UsdMotion::new(&stem, schedule.rate()))),
            Kind::Obj => None,
        };
        let form = match writer {
            Some(writer) => Form::One { writer, temporary: BufWriter::new(files.temporary()?) },
            None => Form::Sequence { names: Vec::new(), bytes: 0 },
        };
        Ok(Sink { output: output.into(), files, form })
    }

    /// Adds the surface at a time \[s\].
    pub fn frame(&mut self, surface: &Reconstruction, time: f64) -> Result<(), Failure> {
        let failed = |path: &Path| {
            let path = path.to_path_buf();
            move |e: io::Error| Failure::io(&path, &e)
        };
        match &mut self.form {
            Form::One { writer, temporary } => {
                let bytes = writer.frame(surface, time)?;
                temporary.write_all(&bytes).map_err(failed(&self.output))
            }
            Form::Sequence { names, bytes } => {
                check_frame(surface, names.len())?;
                let text = obj(surface);
                let name = frame_name(&self.output, names.len() + 1)?;
                let mut file = self.files.create(&name)?;
                file.write_all(text.as_bytes()).map_err(failed(&self.output.with_file_name(&name)))?;
                *bytes += text.len() as u64;
                names.push(name);
                Ok(())
            }
        }
    }

    /// Puts the files in their places; with frames of an older sequence that are not replaced, removes them.
    pub fn finish(mut self) -> Result<Written, Failure> {
        let output = self.output;
        let path = |name: &str| output.with_file_name(name).display().to_string();
        match self.form {
            Form::One { writer, temporary } => {
                let name = name_of(&output)?;
                let parts = writer.finish()?;
                let file = BufWriter::new(self.files.create(name)?);
                let bytes = temporary.into_inner().map_err(io::IntoInnerError::into_error);
                let bytes = bytes.and_then(|from| join(parts, from, file)).map_err(|e| Failure::io(&output, &e))?;
                self.files.commit()?;
                Ok(Written { files: vec![path(name)], bytes })
            }
            Form::Sequence { names, bytes } => {
                self.files.commit()?;
                for name in older(&output)?.iter().filter(|name| !names.contains(name)) {
                    let stale = output.with_file_name(name);
                    fs::remove_file(&stale).map_err(|e| Failure::io(&stale, &e))?;
                }
                Ok(Written { files: names.iter().map(|name| path(name)).collect(), bytes })
            }
        }
    }
}

/// Writes the parts of a file, and returns their bytes.
fn join(parts: Vec<Part>, mut from: File, mut to: BufWriter<File>) -> io::Result<u64> {
    let mut bytes = 0;
    for part in parts {
        match part {
            Part::Bytes(list) => {
                to.write_all(&list)?;
                bytes += list.len() as u64;
            }
            Part::Written(range) => {
                let length = range.end - range.start;
                from.seek(SeekFrom::Start(range.start))?;
                if io::copy(&mut (&mut from).take(length), &mut to)? != length {
                    return Err(io::ErrorKind::UnexpectedEof.into());
                }
                bytes += length;
            }
        }
    }
    to.flush()?;
    Ok(bytes)
}

/// The name of the output.
fn name_of(output: &Path) -> Result<&str, Failure> {
    let name = output.file_name().and_then(|name| name.to_str());
    name.ok_or_else(|| Failure::refused(format!("{}: it does not end in a name in UTF-8", output.display())))
}

/// The name of a frame's file: `flag_00001.obj` of `flag.obj`.
fn frame_name(output: &Path, number: usize) -> Result<String, Failure> {
    let name = name_of(output)?;
    let (stem, extension) = name.rsplit_once('.').unwrap_or((name, "obj"));
    Ok(format!("{stem}_{number:05}.{extension}"))
}

/// The names of files that are there and named as frames of a sequence, sorted.
fn older(output: &Path) -> Result<Vec<String>, Failure> {
    let folder = output.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = name_of(output)?;
    let (stem, extension) = name.rsplit_once('.').unwrap_or((name, "obj"));
    let is_frame = |name: &str| {
        let number =
            name.strip_prefix(stem).and_then(|n| n.strip_prefix('_')?.strip_suffix(extension)?.strip_suffix('.'));
        number.is_some_and(|n| n.len() >= 5 && n.bytes().all(|b| b.is_ascii_digit()))
    };
    let failed = |e: io::Error| Failure::io(folder, &e);
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?.file_name();
        found.extend(entry.to_str().filter(|name| is_frame(name)).map(String::from));
    }
    found.sort();
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_numbered_and_found() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("my.flag.obj");
        assert_eq!(frame_name(&output, 7).unwrap(), "my.flag_00007.obj");
        assert_eq!(frame_name(&output, 123_456).unwrap(), "my.flag_123456.obj");
        for name in ["my.flag_00001.obj", "my.flag_123456.obj", "my.flag_1.obj", "my.flag_0000x.obj", "flag_00001.obj"]
        {
            fs::write(folder.path().join(name), "").unwrap();
        }
        assert_eq!(older(&output).unwrap(), ["my.flag_00001.obj", "my.flag_123456.obj"]);
    }
}
