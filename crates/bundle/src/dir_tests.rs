use super::*;
use crate::bundle::tests::sample;

/// The names in a folder, sorted.
pub(super) fn names(path: &Path) -> Vec<String> {
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
        // A crafted manifest cannot have other files removed.
        let listing = r#"{"format": "gimage-bundle", "version": 1, "files": {"thesis.txt": {}}}"#;
        fs::write(p.join("manifest.json"), listing).unwrap();
        fs::write(p.join("thesis.txt"), "").unwrap();
    });
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

#[test]
fn force_keeps_an_image_of_the_user_in_a_bundle() {
    let scratch = tempfile::tempdir().unwrap();
    let path = scratch.path().join("a.gim");
    write_dir(&sample(), &path, false).unwrap();
    fs::write(path.join("painted.exr"), "by hand").unwrap();
    let error = write_dir(&sample(), &path, true).unwrap_err().to_string();
    assert!(error.contains("painted.exr") && error.contains("does not list"), "{error}");
    assert_eq!(fs::read_to_string(path.join("painted.exr")).unwrap(), "by hand");
    assert_eq!(validate_dir(&path).unwrap().1, []);
    // One that comes while the new bundle is being written, too.
    fs::remove_file(path.join("painted.exr")).unwrap();
    let staged = Staged::write(&sample().encode().unwrap(), &path, true).unwrap();
    fs::write(path.join("painted.exr"), "by hand").unwrap();
    assert!(staged.commit().is_err());
    assert_eq!(names(scratch.path()), ["a.gim"]);
    fs::remove_file(path.join("painted.exr")).unwrap();
    // Files that the manifest of an unknown version lists are replaced.
    let newer =
        r#"{"format": "gimage-bundle", "version": 9, "files": {"new.exr": 1}, "pieces": [{"maps": {"a": "b.exr"}}]}"#;
    fs::remove_dir_all(&path).unwrap();
    fs::create_dir(&path).unwrap();
    for (name, text) in [("manifest.json", newer), ("new.exr", ""), ("b.exr", ""), ("render.glb", "")] {
        fs::write(path.join(name), text).unwrap();
    }
    write_dir(&sample(), &path, true).unwrap();
    assert_eq!(validate_dir(&path).unwrap().1, []);
}

/// Leaves a scratch directory as a killed process does.
fn kill(staged: Staged) {
    staged.scratch.die();
}

#[test]
fn a_writer_killed_at_any_moment_leaves_the_old_or_the_new_bundle() {
    use super::replace::{Swap, replace_by};
    let (old, new) = (sample().encode().unwrap(), {
        let mut bundle = sample();
        bundle.manifest.generator = "new".into();
        bundle.encode().unwrap()
    });
    for moment in 0..4 {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a.gim");
        write_files(&old, &path, false).unwrap();
        let staged = Staged::write(&new, &path, true).unwrap();
        // Between the two renames of a system that cannot swap, the bundle is nowhere but aside.
        let aside = || fs::rename(&path, staged.scratch.aside(&path).unwrap()).unwrap();
        match moment {
            0 => {}
            1 => aside(),
            2 => {
                aside();
                fs::rename(&staged.new, &path).unwrap();
            }
            _ => replace_by(|_, _| Ok(Swap::Unsupported), &staged.scratch, &staged.new, &path).unwrap(),
        }
        kill(staged);
        let (bundle, faults) = validate_dir(&path).unwrap();
        assert_eq!((bundle.manifest.generator == "new", faults), (moment > 1, vec![]), "{moment}");
        // A live writer beside it removes what is left, and its own.
        write_files(&new, &path, true).unwrap();
        assert_eq!(names(place.path()), ["a.gim"], "{moment}");
        assert_eq!(read_dir(&path).unwrap().manifest.generator, "new");
    }
}

#[test]
fn a_bundle_that_cannot_be_replaced_stays() {
    use super::replace::{Swap, replace_by};
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("a.gim");
    write_dir(&sample(), &path, false).unwrap();
    let staged = Staged::write(&sample().encode().unwrap(), &path, true).unwrap();
    // The folder that should take its place is not there.
    let missing = place.path().join("nothing");
    for swap in [Ok(Swap::Unsupported), Err(ErrorKind::PermissionDenied)] {
        assert!(replace_by(|_, _| swap.map_err(Into::into), &staged.scratch, &missing, &path).is_err());
        assert_eq!(validate_dir(&path).unwrap().1, []);
    }
    drop(staged);
    assert_eq!(names(place.path()), ["a.gim"]);
}

#[test]
#[cfg(target_os = "linux")]
fn an_existing_bundle_is_never_missing_while_it_is_replaced() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("a.gim");
    let files = sample().encode().unwrap();
    write_files(&files, &path, false).unwrap();
    let done = std::sync::atomic::AtomicBool::new(false);
    std::thread::scope(|threads| {
        threads.spawn(|| {
            for _ in 0..100 {
                write_files(&files, &path, true).unwrap();
            }
            done.store(true, std::sync::atomic::Ordering::Relaxed);
        });
        while !done.load(std::sync::atomic::Ordering::Relaxed) {
            assert!(path.join("manifest.json").exists());
        }
    });
    assert_eq!(names(place.path()), ["a.gim"]);
}

#[test]
fn names_of_full_length_are_written_and_longer_ones_refused_before_the_work() {
    let place = tempfile::tempdir().unwrap();
    let path = |length| place.path().join("n".repeat(length));
    for length in [243, 255] {
        check_target(&path(length), false).unwrap();
        write_dir(&sample(), &path(length), false).unwrap();
        write_dir(&sample(), &path(length), true).unwrap();
    }
    assert!(matches!(check_target(&path(256), false), Err(Error::Io { .. })));
    assert!(check_target(&place.path().join("no/such/folder/a.gim"), false).is_err());
    assert_eq!(names(place.path()).len(), 2);
}

#[test]
fn a_file_is_written_as_a_whole_or_not_at_all() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("a.obj");
    drop(Staged::write_file(b"new", &path).unwrap());
    assert_eq!(names(place.path()), [""; 0]);
    fs::write(&path, "old").unwrap();
    let staged = Staged::write_file(b"new", &path).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    staged.commit().unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    kill(Staged::write_file(b"more", &path).unwrap());
    drop(Staged::write_file(b"more", &path).unwrap());
    assert_eq!(names(place.path()), ["a.obj"]);
}
