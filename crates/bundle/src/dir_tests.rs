use super::*;
use crate::bundle::tests::sample;

fn names(path: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(path).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn written_read_and_replaced() {
    let scratch = tempfile::tempdir().unwrap();
    let path = scratch.path().join("a.gim");
    let mut bundle = sample();
    write_dir(&bundle, &path, false).unwrap();
    assert_eq!(read_dir(&path).unwrap().images, bundle.images);
    assert_eq!(validate_dir(&path).unwrap().1, []);
    assert!(matches!(write_dir(&bundle, &path, false), Err(Error::Exists { .. })));

    bundle.images.remove(&(0, crate::MapKind::Uv(1)));
    write_dir(&bundle, &path, true).unwrap();
    assert!(!path.join("tube.uv1.exr").exists());
    assert_eq!(names(scratch.path()), ["a.gim"]);

    fs::create_dir(scratch.path().join("empty")).unwrap();
    write_dir(&bundle, &scratch.path().join("empty"), true).unwrap();
}

#[test]
fn force_does_not_replace_what_is_no_bundle() {
    let scratch = tempfile::tempdir().unwrap();
    let refused = |make: &dyn Fn(&Path)| {
        let path = scratch.path().join("target");
        fs::create_dir(&path).unwrap();
        make(&path);
        let before = names(&path);
        let result = write_dir(&sample(), &path, true);
        assert!(matches!(result, Err(Error::NotABundle { .. })), "{result:?}");
        assert_eq!(names(&path), before);
        assert_eq!(names(scratch.path()), ["target"]);
        fs::remove_dir_all(&path).unwrap();
    };
    let ours = r#"{"format": "gimage-bundle", "version": 9}"#;
    refused(&|p| fs::write(p.join("thesis.txt"), "").unwrap());
    refused(&|p| fs::write(p.join("manifest.json"), r#"{"name": "web app"}"#).unwrap());
    refused(&|p| fs::write(p.join("only.exr"), "").unwrap());
    refused(&|p| {
        fs::write(p.join("manifest.json"), ours).unwrap();
        fs::write(p.join("thesis.txt"), "").unwrap();
    });
    refused(&|p| {
        fs::write(p.join("manifest.json"), ours).unwrap();
        fs::create_dir(p.join("folder.exr")).unwrap();
    });
    let file = scratch.path().join("file");
    fs::write(&file, "kept").unwrap();
    assert!(write_dir(&sample(), &file, true).is_err());
    assert_eq!(fs::read_to_string(&file).unwrap(), "kept");
    assert!(write_dir(&sample(), Path::new(".."), true).is_err());
}

#[test]
fn a_failure_leaves_the_old_bundle_and_nothing_else() {
    let scratch = tempfile::tempdir().unwrap();
    let path = scratch.path().join("a.gim");
    write_dir(&sample(), &path, false).unwrap();
    let mut files = sample().encode().unwrap();
    files.insert("../outside.exr".into(), Vec::new());
    assert!(matches!(write_files(&files, &path, true), Err(Error::FileName { .. })));
    files.remove("../outside.exr");
    // Too long a name for any file system: the write fails half way.
    files.insert("z".repeat(1000), Vec::new());
    assert!(matches!(write_files(&files, &path, true), Err(Error::Io { .. })));
    assert_eq!(names(scratch.path()), ["a.gim"]);
    assert_eq!(validate_dir(&path).unwrap().1, []);
    assert!(write_files(&files, &scratch.path().join("b.gim"), false).is_err());
    assert_eq!(names(scratch.path()), ["a.gim"]);
}

#[test]
fn missing_oversized_and_strange_members_are_errors() {
    let scratch = tempfile::tempdir().unwrap();
    assert!(matches!(read_dir(&scratch.path().join("none")), Err(Error::Io { .. })));
    let path = scratch.path().join("a.gim");
    write_dir(&sample(), &path, false).unwrap();
    fs::File::create(path.join("tube.mass.exr")).unwrap().set_len(1 << 30).unwrap();
    assert!(matches!(read_dir(&path), Err(Error::Exr { file, .. }) if file == "tube.mass.exr"));
    fs::remove_file(path.join("tube.mass.exr")).unwrap();
    assert!(matches!(read_dir(&path), Err(Error::Missing { .. })));
    fs::create_dir(path.join("tube.mass.exr")).unwrap();
    assert!(matches!(read_dir(&path), Err(Error::Io { .. })));
    let (_, faults) = validate_dir(&path).unwrap();
    assert_eq!((faults[0].file.as_str(), crate::exit_code(&faults)), ("tube.mass.exr", 2));
}
