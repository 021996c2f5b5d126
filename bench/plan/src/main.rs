//! Times scenes with each feature on and off, so that what a plan saves can be seen. CSV to stdout.

mod scenes;
mod timing;

use clap::Parser;
use gimage_bench_host::{Gpu, device_columns};
use gimage_runtime::{Backend, Options};
use scenes::{Case, cases};
use timing::{host, time};

/// The cost of a scene: milliseconds per frame with each feature of the runtime on and off. CSV to stdout, the adapter
/// to stderr.
#[derive(Parser)]
#[command(after_help = "Example:\n  plan --particles 64,128 --frames 40 > plan.csv")]
struct Args {
    /// Particles along each side of the cloths, separated by commas.
    #[arg(long, value_delimiter = ',', default_value = "64,128")]
    particles: Vec<u32>,
    /// Frames of 1/60 s that are timed, in each of the rounds.
    #[arg(long, default_value_t = 20)]
    frames: u32,
    /// Rounds over all scenes, so that a busy minute of the machine is spread.
    #[arg(long, default_value_t = 3)]
    rounds: u32,
    /// Steps per frame.
    #[arg(long, default_value_t = 8)]
    substeps: u32,
    /// Threads of the CPU backend; 0 is one for each core.
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Only the CPU backend.
    #[arg(long, conflicts_with = "gpu")]
    cpu: bool,
    /// Only scenes whose names contain this, and the plain ones.
    #[arg(long, default_value = "")]
    only: String,
    /// Only the GPU backend.
    #[arg(long)]
    gpu: bool,
    /// On a device with WebGPU's default limits.
    #[arg(long)]
    web: bool,
}

#[allow(clippy::print_stdout)]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args = Args::parse();
    let gpu = if args.web { Gpu::of_the_web() } else { Gpu::new() };
    match &gpu {
        Ok(Gpu { info, .. }) => {
            eprintln!("adapter: {} ({:?}), driver {} {}", info.name, info.device_type, info.driver, info.driver_info)
        }
        Err(error) => eprintln!("no adapter, CPU backend only: {error}"),
    }
    let gpu = gpu.ok();
    println!(
        "particles,scene,backend,dispatches,bytes,frames,ms_min,ms_median,ms_min_vs_plain,ms_median_vs_plain,device_ms_min,device_ms_median"
    );
    for &n in &args.particles {
        let mut cases = cases(n)?;
        cases.retain(|c| c.name.contains(&args.only) || ["plain", "xpbd"].contains(&c.name));
        for backend in [Backend::Cpu, Backend::Gpu] {
            let device = gpu.as_ref().filter(|_| backend == Backend::Gpu && !args.cpu);
            if if backend == Backend::Gpu { device.is_none() } else { args.gpu } {
                continue;
            }
            let options =
                Options { backend, substeps: Some(args.substeps), threads: args.threads, ..Options::default() };
            let mut times: Vec<Vec<f64>> = vec![Vec::new(); cases.len()];
            let mut device_times = times.clone();
            let mut plans = Vec::new();
            for round in 0..args.rounds {
                for ((case, times), device_times) in cases.iter().zip(&mut times).zip(&mut device_times) {
                    let mut host = host(case, &options, device)?;
                    for (ms, device_ms) in time(&mut host, args.frames)? {
                        times.push(ms);
                        device_times.extend(device_ms);
                    }
                    if round == 0 {
                        plans.push(host.stepper.plan());
                    }
                }
            }
            // Sorted: the least, and the middle one.
            times.iter_mut().for_each(|t| t.sort_by(f64::total_cmp));
            let figures: Vec<[f64; 2]> = times.iter().map(|t| [t[0], t[t.len() / 2]]).collect();
            for ((((Case { name, options, .. }, times), device_times), plan), [least, median]) in
                cases.iter().zip(&times).zip(&mut device_times).zip(&plans).zip(&figures)
            {
                let (dispatches, bytes) = (plan.dispatches(), plan.bytes());
                let plain =
                    cases.iter().position(|c| c.options.solver == options.solver).map_or([0.0; 2], |k| figures[k]);
                let over = [least - plain[0], median - plain[1]];
                let backend = if backend == Backend::Cpu { "cpu" } else { "gpu" };
                let frames = times.len();
                let on_device = device_columns(device_times);
                println!(
                    "{n},{name},{backend},{dispatches},{bytes},{frames},{least:.3},{median:.3},{:+.3},{:+.3},{on_device}",
                    over[0], over[1]
                );
            }
        }
    }
    Ok(())
}
