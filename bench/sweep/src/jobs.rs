//! The sweep: which meshes at which settings, run in order, then the tables.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use tempfile::TempDir;

use crate::Failure;
use crate::args::{SampleArg, SweepArgs, matches};
use crate::record::{Record, Status};
use crate::shape::Shape;
use crate::{budgets, damage, garments, hard, launch, table};

/// Where a mesh comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Origin {
    File(usize),
    Hard(usize),
    Large(u32),
    Damaged(usize),
}

/// One build.
struct Job {
    origin: Origin,
    name: String,
    texels: u32,
    sample: SampleArg,
}

/// All that makes meshes.
struct Sources<'a> {
    args: &'a SweepArgs,
    files: Vec<PathBuf>,
    parts: Vec<(String, Shape)>,
    hard: usize,
}

/// Runs it; whether every requirement holds.
pub fn run(args: &SweepArgs) -> Result<bool, Failure> {
    let mut sources = Sources { args, files: Vec::new(), parts: Vec::new(), hard: 0 };
    let jobs = jobs(&mut sources)?;
    if jobs.is_empty() {
        return Err(
            "no mesh to build; give a folder with .obj, .glb or .gltf files, --hard, --damaged, --large N or --budgets N".into()
        );
    }
    if let Some(folder) = &args.write_meshes {
        std::fs::create_dir_all(folder)?;
    }
    let records = build_all(&sources, &jobs)?;
    if args.dry_run {
        return Ok(true);
    }
    let (mut text, mut sound) = (String::new(), true);
    if args.budgets.is_some() {
        (text, sound) = budgets::summary(&records);
    }
    let (tables, holds) = table::summary(&records, args.limit_seconds as f64, args.worst);
    std::io::stdout().write_all((text + &tables).as_bytes())?;
    Ok(sound && holds)
}

/// Every build asked for, in order.
fn jobs(sources: &mut Sources<'_>) -> Result<Vec<Job>, Failure> {
    let args = sources.args;
    let mut meshes: Vec<(Origin, String)> = Vec::new();
    for path in &args.paths {
        for file in garments::under(path)? {
            let name = file.strip_prefix(path).ok().filter(|p| p.file_name().is_some()).unwrap_or(&file);
            meshes.push((Origin::File(sources.files.len()), name.display().to_string()));
            sources.files.push(file);
        }
    }
    if args.budgets.is_some() && args.paths.is_empty() && !args.hard && !args.damaged && args.large.is_none() {
        for file in gimage_bench_meshes::clean() {
            let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
            meshes.push((Origin::File(sources.files.len()), name));
            sources.files.push(file);
        }
    }
    if args.hard {
        sources.hard = args.count.unwrap_or(1000);
        meshes.extend((0..sources.hard).map(|k| (Origin::Hard(k), hard::name(k))));
    }
    meshes.extend(args.large.map(|n| (Origin::Large(n), hard::skirt::NAME.to_owned())));
    if args.damaged {
        sources.parts = garments::parts()?;
        let parts = &sources.parts;
        let count = args.count.unwrap_or(3000);
        meshes.extend((0..count).map(|k| (Origin::Damaged(k), damage::name(k, parts))));
    }
    let (first, step) = args.shard.map_or((0, 1), |(i, n)| (i - 1, n));
    let wanted = |name: &str| args.filter.as_ref().is_none_or(|f| matches(f, name));
    let texels = args.budgets.map_or_else(|| vec![args.texels], budgets::budgets);
    let kept = meshes.into_iter().filter(|m| wanted(&m.1)).skip(first).step_by(step);
    let mut out = Vec::new();
    for (origin, name) in kept {
        for &sample in &args.sample {
            let job = |&texels: &u32| Job { origin, name: name.clone(), texels, sample };
            out.extend(texels.iter().map(job));
        }
    }
    Ok(out)
}

impl Sources<'_> {
    /// The file of a mesh; a generated one is written to `folder`, and kept where that is asked for.
    fn file(&self, job: &Job, folder: &Path) -> Result<PathBuf, Failure> {
        let shape = match job.origin {
            Origin::File(k) => return Ok(self.files[k].clone()),
            Origin::Hard(k) => hard::mesh(self.args.seed, k, self.hard).1,
            Origin::Large(triangles) => hard::skirt::skirt(self.args.seed, triangles as usize),
            Origin::Damaged(k) => damage::mesh(self.args.seed, k, &self.parts).1,
        };
        let path = self.args.write_meshes.as_deref().unwrap_or(folder).join(format!("{}.obj", job.name));
        std::fs::write(&path, shape.obj())?;
        Ok(path)
    }

    fn build(&self, job: &Job, folder: &Path) -> Result<Option<Record>, Failure> {
        let path = self.file(job, folder)?;
        if self.args.dry_run {
            return Ok(None);
        }
        let record = launch::run(self.args, &path, &job.name, job.texels, job.sample, folder);
        if path.starts_with(folder) {
            std::fs::remove_file(&path)?;
        }
        record.map(Some)
    }
}

/// Builds everything, in as many threads as there are builds at a time. Rows go to the CSV as they come, so that a sweep
/// that is stopped leaves what it had; the records are in the order of the jobs.
fn build_all(sources: &Sources<'_>, jobs: &[Job]) -> Result<Vec<Record>, Failure> {
    let args = sources.args;
    let csv = args.csv.as_ref().map(std::fs::File::create).transpose()?;
    let csv = csv.map(|mut f| writeln!(f, "{}", table::COLUMNS).map(|()| f)).transpose()?;
    let (next, csv) = (AtomicUsize::new(0), Mutex::new(csv));
    let work = || -> Result<Vec<(usize, Record)>, Failure> {
        let folder = TempDir::new()?;
        let mut done = Vec::new();
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            let Some(job) = jobs.get(k) else { return Ok(done) };
            let Some(record) = sources.build(job, folder.path())? else { continue };
            eprintln!("{} of {}: {}", k + 1, jobs.len(), told(&record));
            if let Some(file) = csv.lock().unwrap_or_else(|e| e.into_inner()).as_mut() {
                table::rows(&record).iter().try_for_each(|row| writeln!(file, "{row}"))?;
            }
            done.push((k, record));
        }
    };
    let results: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..args.jobs.max(1)).map(|_| scope.spawn(work)).collect();
        threads.into_iter().map(|t| t.join().unwrap_or_else(|_| Err("a thread of the sweep panicked".into()))).collect()
    });
    let mut all = Vec::with_capacity(jobs.len());
    for result in results {
        all.extend(result?);
    }
    all.sort_by_key(|r| r.0);
    Ok(all.into_iter().map(|r| r.1).collect())
}

/// One build in one line.
fn told(r: &Record) -> String {
    let head = format!("{} ({} texels, {}) {:.1} s", r.mesh, r.texels, r.sample, r.cpu);
    match &r.status {
        Status::Built => {
            let worst = r.pieces.iter().filter_map(|p| p.worst_psnr()).reduce(f64::min);
            let word = r.pieces.iter().map(crate::verdict::grade).max();
            format!("{head}: {} pieces, {word:?}, {} dB", r.pieces.len(), worst.map_or("-".into(), table::short))
        }
        other => format!("{head}: {other:?}"),
    }
}
