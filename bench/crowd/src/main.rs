//! Times crowds: 1 to 1,000 garments that share the images of one. CSV to stdout.

mod characters;
mod counts;
mod garment;

use std::path::PathBuf;
use std::time::Instant;

use clap::Parser;
use gimage_bench_host::{FRAME, Gpu, Host, device_columns};
use gimage_runtime::{Backend, Options};

/// Frames before the clock starts: pipelines are made, and buffers first touched.
const WARM_UP: u32 = 3;

/// The cost of a crowd: milliseconds per frame and per garment, and bytes, on the CPU backend and on the GPU. CSV to stdout, the
/// adapter to stderr.
#[derive(Parser)]
#[command(
    after_help = "Example:\n  crowd --particles 32 --garments 1,100 --threads 1,0 > crowd.csv\n  crowd --counts\n  crowd --characters 100"
)]
struct Args {
    /// Particles along each side of a garment, separated by commas.
    #[arg(long, value_delimiter = ',', default_value = "32,64")]
    particles: Vec<u32>,
    /// Numbers of garments, separated by commas.
    #[arg(long, value_delimiter = ',', default_value = "1,10,100,1000")]
    garments: Vec<u32>,
    /// Levels of detail, separated by commas: 0 is the whole image.
    #[arg(long, value_delimiter = ',', default_value = "0,1")]
    levels: Vec<u32>,
    /// Threads of the CPU backend, separated by commas; 0 is one for each core.
    #[arg(long, value_delimiter = ',', default_value = "1,0")]
    threads: Vec<usize>,
    /// Frames of 1/60 s that are timed, at most.
    #[arg(long, default_value_t = 40)]
    frames: u32,
    /// Seconds after which no more frames of a row are timed, from the third on.
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// Steps per frame.
    #[arg(long, default_value_t = 8)]
    substeps: u32,
    /// Only the CPU backend.
    #[arg(long, conflicts_with = "gpu")]
    cpu: bool,
    /// Only the GPU backend.
    #[arg(long)]
    gpu: bool,
    /// Instead of times: dispatches, queue writes, host time and bytes of scenes with many cloths, on a device with WebGPU's
    /// default limits.
    #[arg(long, conflicts_with = "cpu")]
    counts: bool,
    /// On a device with WebGPU's default limits.
    #[arg(long, conflicts_with = "cpu")]
    web: bool,
    /// Instead of times: the sizes of workgroups and of tiles that `Stepper::tune` finds.
    #[arg(long, conflicts_with_all = ["cpu", "counts"])]
    tune: bool,
    /// Instead of garments: dressed characters on the CPU, alone on one core and in these numbers on all cores, separated by commas.
    #[arg(long, value_delimiter = ',', conflicts_with_all = ["gpu", "counts"])]
    characters: Vec<u32>,
    /// The character: a file with a body, clothes and an animation.
    #[arg(long, default_value = "assets/figure.glb")]
    file: PathBuf,
    /// Its animation.
    #[arg(long, default_value = "Walk")]
    animation: String,
}

#[allow(clippy::print_stdout)]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args = Args::parse();
    if !args.characters.is_empty() {
        return characters::print(&args.file, &args.animation, &args.characters, args.frames);
    }
    if args.counts {
        return Ok(counts::print(&Gpu::of_the_web()?, args.substeps)?);
    }
    let gpu = match (args.cpu, args.web) {
        (true, _) => Err("not asked for".into()),
        (_, true) => Gpu::of_the_web(),
        _ => Gpu::new(),
    };
    match &gpu {
        Ok(Gpu { info, .. }) => {
            eprintln!("adapter: {} ({:?}), driver {} {}", info.name, info.device_type, info.driver, info.driver_info)
        }
        Err(error) => eprintln!("no adapter, CPU backend only: {error}"),
    }
    if args.tune {
        let gpu = gpu?;
        println!("{:?}", gimage_runtime::Stepper::tune(&gpu.device, &gpu.queue)?);
        return Ok(());
    }
    let gpu = gpu.ok();
    let cpu = args.threads.iter().map(|threads| (None, *threads)).filter(|_| !args.gpu);
    let backends: Vec<_> = cpu.chain(gpu.iter().map(|gpu| (Some(gpu), 1))).collect();
    println!(
        "particles,level,garments,backend,threads,dispatches,frames,ms_min,ms_median,ms_per_garment,\
         images,images_unshared,states,device_images,device_states,device_ms_min,device_ms_median"
    );
    for (&n, &level) in args.particles.iter().flat_map(|n| args.levels.iter().map(move |level| (n, level))) {
        for &(gpu, threads) in &backends {
            for &garments in &args.garments {
                let backend = if gpu.is_some() { Backend::Gpu } else { Backend::Cpu };
                let options = Options { backend, threads, substeps: Some(args.substeps), ..Options::default() };
                let mut host = Host::new(garment::crowd(n, garments)?, options, gpu)?;
                let all: Vec<_> = (0..garments as usize).map(|cloth| (cloth.into(), level)).collect();
                host.stepper.set_levels(&all)?;
                let (mut times, mut device_times) = times(&mut host, &args)?;
                times.sort_by(f64::total_cmp);
                let on_device = device_columns(&mut device_times);
                let (least, median) = (times[0], times[times.len() / 2]);
                let each = median / f64::from(garments);
                let (memory, dispatches) = (host.stepper.memory(), host.stepper.plan().dispatches());
                let name = if gpu.is_some() { "gpu" } else { "cpu" };
                println!(
                    "{n},{level},{garments},{name},{threads},{dispatches},{},{least:.3},{median:.3},{each:.4},{},{},{},{},{},{on_device}",
                    times.len(),
                    memory.images,
                    memory.images_unshared,
                    memory.states,
                    memory.device_images,
                    memory.device_states,
                );
            }
        }
    }
    Ok(())
}

/// Milliseconds of each frame: from recording to the end of the work, and by the clock of the device, if it has one.
fn times(host: &mut Host, args: &Args) -> gimage_runtime::Result<(Vec<f64>, Vec<f64>)> {
    let start = Instant::now();
    (0..WARM_UP).try_for_each(|_| host.timed(FRAME).map(drop))?;
    let (mut times, mut device_times) = (Vec::new(), Vec::new());
    while times.len() < args.frames.max(1) as usize && (times.len() < 3 || start.elapsed().as_secs_f64() < args.seconds)
    {
        times.push(host.timed(FRAME)?);
        device_times.extend(host.device_ms());
    }
    Ok((times, device_times))
}
