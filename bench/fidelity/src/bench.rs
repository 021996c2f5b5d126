//! The benchmark: timed builds in shuffled rounds, then quality, then the peers; table, plot and machine to a folder.

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::Failure;
use crate::args::{BenchArgs, PeerArg, name};
use crate::job::{self, Job};
use crate::measured::summary;
use crate::one::Run;
use crate::quality::{Scorer, of_bundle};
use crate::row::{Row, csv};
use crate::source::{Reference, stem};
use crate::{machine, peer, plot};

/// Inputs that every step needs.
struct Bench<'a> {
    args: &'a BenchArgs,
    meshes: Vec<PathBuf>,
    references: Vec<Reference>,
    scorer: Option<Scorer>,
    /// Holds one bundle, or the images of one peer, at a time.
    scratch: TempDir,
}

/// Runs it.
pub fn run(args: &BenchArgs) -> Result<(), Failure> {
    let meshes = if args.meshes.is_empty() { gimage_bench_meshes::clean() } else { args.meshes.clone() };
    let machine = machine::describe(args);
    let references = meshes.iter().map(|m| Reference::read(m)).collect::<Result<Vec<_>, _>>()?;
    let scorer = args.scorer.clone().map(|script| Scorer { python: args.python.clone(), script });
    let bench = Bench { args, meshes, references, scorer, scratch: TempDir::new()? };
    let mut rows = bench.builds()?;
    bench.save(&mut rows, &machine)?;
    for mesh in 0..bench.meshes.len() {
        for &peer in &args.peers {
            rows.extend(bench.peer(mesh, peer)?);
            // A peer may take long: what is there is kept if the run is stopped.
            bench.save(&mut rows, &machine)?;
        }
    }
    Ok(())
}

impl Bench<'_> {
    fn save(&self, rows: &mut [Row], machine: &str) -> Result<(), Failure> {
        // All rows of a mesh together, gimage first.
        rows.sort_by_key(|row| self.meshes.iter().position(|m| stem(m) == row.mesh));
        let folder = self.args.runs.join(&self.args.name);
        std::fs::create_dir_all(&folder)?;
        std::fs::write(folder.join("machine.txt"), machine)?;
        std::fs::write(folder.join("fidelity.csv"), csv(rows))?;
        std::fs::write(folder.join("fidelity.svg"), plot::draw(rows))?;
        Ok(())
    }
}

impl Bench<'_> {
    fn builds(&self) -> Result<Vec<Row>, Failure> {
        let jobs = job::all(self.args, self.meshes.len());
        let mut runs: Vec<Vec<Run>> = vec![Vec::new(); jobs.len()];
        // The first failure of a job; it is not tried again.
        let mut failed: Vec<Option<String>> = vec![None; jobs.len()];
        let bundle = self.scratch.path().join("bundle.gim");
        for round in 0..self.args.repeat {
            for (done, k) in job::order(jobs.len(), round).into_iter().enumerate() {
                if failed[k].is_some() {
                    continue;
                }
                let mesh = &self.meshes[jobs[k].mesh];
                eprintln!("round {}, {} of {}: {}", round + 1, done + 1, jobs.len(), self.title(&jobs[k]));
                match jobs[k].setting.build(mesh, &bundle, false, self.args.threads) {
                    Ok(run) => runs[k].push(run),
                    Err(e) => failed[k] = Some(e.to_string()),
                }
            }
        }
        jobs.iter()
            .enumerate()
            .map(|(k, job)| {
                eprintln!("quality, {} of {}: {}", k + 1, jobs.len(), self.title(job));
                let triangles = self.references[job.mesh].triangles.len();
                let row = self.row(job);
                Ok(match failed[k].take() {
                    Some(error) => Row { error, ..row },
                    None => {
                        let values = summary(&runs[k], triangles);
                        self.quality(job, Row { values, ..row }, &bundle)
                    }
                })
            })
            .collect()
    }

    fn row(&self, job: &Job) -> Row {
        Row {
            mesh: stem(&self.meshes[job.mesh]),
            method: "gimage".into(),
            texels: job.setting.texels,
            sample: name(job.setting.sample),
            seams: name(job.setting.seams),
            effort: name(job.setting.effort),
            detail: job.setting.detail.to_string(),
            ..Row::default()
        }
    }

    fn title(&self, job: &Job) -> String {
        let (mesh, s) = (stem(&self.meshes[job.mesh]), job.setting);
        let [sample, seams, effort] = [name(s.sample), name(s.seams), name(s.effort)];
        format!("{mesh} {}^2 {sample} {seams} {effort} {}", s.texels, s.detail)
    }

    /// The untimed build of a job, measured and scored. The bytes are those of the timed builds, the metrics aside.
    fn quality(&self, job: &Job, mut row: Row, bundle: &Path) -> Row {
        let mesh = &self.meshes[job.mesh];
        let measured = job.setting.build(mesh, bundle, true, self.args.threads).and_then(|_| of_bundle(bundle));
        match measured {
            Ok((values, sizes)) => {
                row.values.extend(values);
                row.sizes = sizes;
                self.score("bundle", mesh, bundle, &mut row);
            }
            Err(e) => row.error = e.to_string(),
        }
        row
    }

    fn score(&self, kind: &str, mesh: &Path, made: &Path, row: &mut Row) {
        match self.scorer.as_ref().map(|s| s.score(kind, mesh, made)) {
            Some(Ok(values)) => row.values.extend(values),
            Some(Err(e)) => row.error = format!("scorer: {e}"),
            None => {}
        }
    }

    /// One peer on one mesh: a row for each texel budget.
    fn peer(&self, mesh: usize, peer: PeerArg) -> Result<Vec<Row>, Failure> {
        let (path, reference) = (&self.meshes[mesh], &self.references[mesh]);
        eprintln!("{}: {}", name(peer), stem(path));
        let folder = self.scratch.path();
        let obj = folder.join("mesh.obj");
        std::fs::write(&obj, reference.obj())?;
        let texels = if self.args.peer_texels.is_empty() { &self.args.texels } else { &self.args.peer_texels };
        let row = |texels| Row { mesh: stem(path), method: name(peer), texels, ..Row::default() };
        let report = match peer::run(peer, &self.args.python, &obj, folder, texels, self.args.repeat) {
            Ok(report) => report,
            Err(e) => return Ok(vec![Row { error: e.to_string(), ..row(texels[0]) }]),
        };
        let mut rows = Vec::new();
        for image in &report.images {
            let mut row = Row { sizes: image.sizes.clone(), ..row(image.texels) };
            match report.values(image, reference) {
                Ok(values) => {
                    row.values = values;
                    self.score("image", path, &image.path, &mut row);
                }
                Err(e) => row.error = e.to_string(),
            }
            report.clear(&mut row.values);
            rows.push(row);
        }
        Ok(rows)
    }
}
