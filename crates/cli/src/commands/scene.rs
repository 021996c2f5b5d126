//! The scene that a command steps: a built-in scene, a scene file, or a bundle.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use gimage::options::{BuildOptions, ImageSize};
use gimage::pipeline;
use gimage::progress::Quiet;
use gimage_bundle::Bundle;
use gimage_bundle::dir::read_dir;
use gimage_runtime::draw::{Look, SolidLook};
use gimage_runtime::scene::file::{Found, MAX_BYTES, SceneFile, Source};
use gimage_runtime::scene::{BUILTIN, Script, builtin};
use gimage_runtime::{
    Backend, BodyCollider, ClearedStart, Cloth, ClothContact, ContactTier, Options, Quality, Scene, Skinning, Solver,
};

use crate::args::{BackendArg, ClearStartArg, ContactArg, SceneArgs, SolverArg};
use crate::commands::character::{self, Animated, Reading, SkinningArg};
use crate::exit::Failure;

/// A scene, and what moves its joints, if anything does.
pub struct Loaded {
    pub file: SceneFile,
    /// The bundle of each cloth that is not flat.
    pub bundles: Vec<Option<Bundle>>,
    pub animated: Option<Arc<Animated>>,
    /// How each cloth was cleared of what it began in; empty where it was not asked for.
    pub cleared: Arc<[ClearedStart]>,
}

/// Loads what the arguments name, with the solver settings and the animation that they give.
pub fn load(args: &SceneArgs) -> Result<Loaded, Failure> {
    let mut loaded = open_moving(args)?;
    let SceneFile { scene, options, clear_start, .. } = &mut loaded.file;
    let is_cleared = match args.clear_start {
        ClearStartArg::Auto => clear_start.unwrap_or_else(|| scene.is_to_clear(options)),
        ClearStartArg::On => true,
        ClearStartArg::Off => false,
    };
    if is_cleared {
        loaded.cleared = scene.clear_start(options)?.into();
    }
    Ok(loaded)
}

/// The scene with its settings, where its animation begins.
fn open_moving(args: &SceneArgs) -> Result<Loaded, Failure> {
    let Opened { mut file, bundles, reading, source } = open_with(args.scene(), args.n)?;
    file.options.backend = match args.backend {
        BackendArg::Auto => Backend::Auto,
        BackendArg::Gpu => Backend::Gpu,
        BackendArg::Cpu => Backend::Cpu,
    };
    if let Some(solver) = args.solver {
        file.options.solver = match solver {
            SolverArg::Classic => Solver::Classic,
            SolverArg::Xpbd => Solver::Xpbd,
        };
    }
    if args.thickness.is_some() && Path::new(args.scene()).is_dir() {
        // The thickness that a bundle has is a default.
        file.scene.cloths.iter_mut().for_each(|cloth| cloth.thickness = None);
    }
    if let Some(material) = &args.material {
        file.scene.cloths.iter_mut().try_for_each(|cloth| cloth.set_material(material))?;
    }
    for cloth in &mut file.scene.cloths {
        cloth.contact = match args.contact {
            None => cloth.contact,
            Some(ContactArg::Off) => None,
            Some(ContactArg::Particles) => {
                Some(ClothContact { tier: ContactTier::Particles, ..cloth.contact.unwrap_or_default() })
            }
            Some(ContactArg::Safe) => {
                Some(ClothContact { tier: ContactTier::Safe, ..cloth.contact.unwrap_or_default() })
            }
        };
    }
    if let Some(skinning) = args.motion.skinning {
        let skinning = match skinning {
            SkinningArg::Linear => Skinning::Linear,
            SkinningArg::DualQuaternion => Skinning::DualQuaternion,
        };
        file.scene.cloths.iter_mut().for_each(|cloth| cloth.skinning = skinning);
    }
    file.options.substeps = args.substeps.or(file.options.substeps);
    // Steps that are asked for by number are not chosen by the scene.
    let quality = if args.substeps.is_some() { Quality::Fixed } else { file.options.quality };
    file.options.quality = Quality::of(args.error.or(quality.target()), args.budget.or(quality.budget()));
    file.options.thickness = args.thickness.unwrap_or(file.options.thickness);
    file.options.pyramid = args.pyramid.unwrap_or(file.options.pyramid);
    file.options.polish = args.polish.or(file.options.polish);
    file.options.tethers = args.tethers.unwrap_or(file.options.tethers);
    file.options.iterations = args.iterations.unwrap_or(file.options.iterations);
    file.options.threads = args.threads.into();
    let scene = Path::new(args.scene());
    let named =
        file.character.as_ref().map(|c| (scene.parent().unwrap_or(Path::new("")).join(&c.file), c.animation.clone()));
    let (path, animation) = match (&args.motion.animation, named) {
        (None, None) => {
            let motion = &args.motion;
            let given = [
                ("--character", motion.character.is_some()),
                ("--local", motion.local.is_some()),
                ("--lead", motion.lead.is_some()),
            ];
            if let Some((option, _)) = given.iter().find(|(_, given)| *given) {
                return Err(Failure::refused(format!("{option} needs --animation NAME; `gimage list` has the names")));
            }
            return Ok(Loaded { file, bundles, animated: None, cleared: Arc::default() });
        }
        (animation, Some((path, own))) => {
            (args.motion.character.clone().unwrap_or(path), animation.clone().unwrap_or(own))
        }
        (Some(animation), None) => {
            (character::beside(scene, args.motion.character.as_deref(), &source)?, animation.clone())
        }
    };
    let lead = args.motion.lead.unwrap_or_else(|| character::default_lead(scene));
    let frame = args.motion.local.as_deref().map(|joint| (joint, args.motion.inertia.as_deref()));
    if frame.is_some() && !file.script.is_empty() {
        return Err(Failure::refused(
            "--local: pins, colliders and cuts of the scene's script are in the world; remove one of both",
        ));
    }
    let animated = Animated::new((&path, &animation), reading, (lead, scene.is_dir()), frame, &mut file)?;
    Ok(Loaded { file, bundles, animated: Some(Arc::new(animated)), cleared: Arc::default() })
}

/// Opens the built-in scene of this name with `n` particles per side, the scene file, or the bundle.
pub fn open(name: &str, n: u32) -> Result<SceneFile, Failure> {
    Ok(open_with(name, n)?.file)
}

/// A scene without its animation.
struct Opened {
    file: SceneFile,
    bundles: Vec<Option<Bundle>>,
    /// How the first bundle with joints was read from its file.
    reading: Reading,
    /// The file that the bundle was built from, if the scene is a bundle.
    source: String,
}

impl Opened {
    fn new(file: SceneFile) -> Self {
        Opened { file, bundles: Vec::new(), reading: Reading::default(), source: String::new() }
    }
}

fn open_with(name: &str, n: u32) -> Result<Opened, Failure> {
    let path = Path::new(name);
    if BUILTIN.contains(&name) {
        Ok(Opened::new(plain(builtin(name, n)?)))
    } else if !path.exists() {
        let hint = format!("give a scene file, a bundle, or one of the built-in scenes {}", BUILTIN.join(", "));
        Err(Failure::refused(format!("{name}: no such file or directory; {hint}")))
    } else if path.is_dir() {
        let bundle = read_dir(path).map_err(|e| Failure::bundle(path, &e))?;
        let mut scene = Scene::new(name);
        scene.cloths.push(Cloth::from_bundle(name, &bundle)?);
        let body = BodyCollider::of_bundle(&bundle);
        let joints = body.iter().map(|b| b.joint.clone()).collect();
        scene.colliders = body.into_iter().map(|b| b.collider).collect();
        let (reading, source) = (Reading::of(&bundle.manifest), bundle.manifest.source.file.clone());
        let file = SceneFile { joints, clear_start: Some(true), ..plain(scene) };
        Ok(Opened { file, bundles: vec![Some(bundle)], reading, source })
    } else {
        read(path)
    }
}

fn plain(scene: Scene) -> SceneFile {
    let looks = (0..scene.cloths.len()).map(Look::of).collect();
    let (script, options, solid_look) = (Script::default(), Options::default(), SolidLook::default());
    let (character, sources, joints) = (None, Vec::new(), Vec::new());
    let (clear_start, camera, background) = (None, None, None);
    SceneFile { scene, clear_start, script, options, camera, background, looks, solid_look, character, sources, joints }
}

fn read(path: &Path) -> Result<Opened, Failure> {
    let meta = fs::metadata(path).map_err(|e| Failure::io(path, &e))?;
    let json = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    // A pipe would be waited for, and a device read without end.
    if !json || !meta.is_file() || meta.len() > MAX_BYTES as u64 {
        let what = "neither a bundle (a directory) nor a scene file (.json of at most 16 MiB)";
        return Err(Failure::refused(format!("{}: {what}; build garments with `gimage build` first", path.display())));
    }
    let bytes = fs::read(path).map_err(|e| Failure::io(path, &e))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let (mut reading, mut found) = (None, Vec::new());
    let file = SceneFile::parse(&bytes, |source| {
        let bundle = find(folder, source)?;
        if bundle.manifest.skeleton.is_some() && reading.is_none() {
            reading = Some(Reading::of(&bundle.manifest));
        }
        found.push(bundle.clone());
        Ok(bundle)
    });
    let file = file.map_err(|e| Failure::refused(format!("{}: {e}", path.display())))?;
    // They were asked for in the order of the cloths.
    let mut found = found.into_iter();
    let bundles = file.sources.iter().map(|source| source.as_ref().and_then(|_| found.next())).collect();
    Ok(Opened { bundles, reading: reading.unwrap_or_default(), ..Opened::new(file) })
}

/// Reads a bundle, or builds a garment in memory.
fn find(folder: &Path, source: &Source) -> Found {
    match source {
        Source::Bundle(name) => {
            let path = folder.join(name);
            read_dir(&path).map_err(|e| format!("{}: {e}", path.display()).into())
        }
        Source::Garment { file, texels } => {
            let path = folder.join(file);
            let mut options = BuildOptions::default();
            options.image.size = ImageSize::Texels(*texels);
            options.gate.metrics = false;
            let built = pipeline::build(&path, &options, &Quiet);
            built.map(|b| b.bundle).map_err(|e| format!("{}: {e}", path.display()).into())
        }
    }
}
