use gimage::options::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let mut o = BuildOptions::default();
    o.size = ImageSize::Texels(std::env::var("TEXELS").ok().and_then(|t| t.parse().ok()).unwrap_or(16641));
    if std::env::var("POINT").is_ok() {
        o.sample = Sample::Point;
    }
    if std::env::var("QUICK").is_ok() {
        o.metrics = false;
    }
    let t = std::time::Instant::now();
    match gimage::pipeline::build(a[1].as_ref(), &o, &gimage::progress::Quiet) {
        Ok(b) => {
            for p in &b.bundle.manifest.pieces {
                let q = &p.quality;
                println!(
                    "  {} {}x{} tri {} psnr {:.2?} L2 {:.3?} Linf {:.1?} flips {:?} cut {:?} nrm {:.2?} aniso {:.1?}",
                    p.name,
                    p.width,
                    p.height,
                    p.surface.as_ref().unwrap().triangles,
                    q.psnr.unwrap_or(0.),
                    q.stretch_l2.unwrap(),
                    q.stretch_max.unwrap(),
                    q.flips.unwrap(),
                    p.cut.as_ref().unwrap(),
                    q.normal_degrees.unwrap_or(0.),
                    q.spring_anisotropy
                );
            }
            println!(
                "{} pieces {} acc {} psnr {:?} in {:.2?} {:?}",
                a[1],
                b.bundle.manifest.pieces.len(),
                b.bundle.manifest.accessories.len(),
                b.bundle.manifest.quality.psnr,
                t.elapsed(),
                b.report
                    .stages
                    .iter()
                    .map(|s| format!("{} {:.2}s {}M", s.stage.name(), s.seconds, s.peak_bytes.unwrap_or(0) >> 20))
                    .collect::<Vec<_>>()
            );
            for f in &b.report.findings {
                println!("    {:?} {} {} x{} {:?}", f.severity, f.stage, f.kind, f.count, f.examples.first());
            }
            if let Some(out) = a.get(2) {
                gimage_bundle::dir::write_dir(&b.bundle, out.as_ref(), true).unwrap();
                let (_, f) = gimage_bundle::dir::validate_dir(out.as_ref()).unwrap();
                println!("  validate: {} faults {:?}", f.len(), f.first());
            }
        }
        Err(e) => println!("{}: ERROR {e} in {:.2?}", a[1], t.elapsed()),
    }
}
