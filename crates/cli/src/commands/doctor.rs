//! `gimage doctor`: which adapters there are, whether they compute what the CPU does, and which of them would run.

use std::fmt::Write;

use gimage_runtime::wgpu;
use gimage_runtime::{Mismatch, SelfCheck};
use serde_json::{Value, json};

use crate::args::DoctorArgs;
use crate::commands::device::Device;
use crate::exit::{Exit, Failure};
use crate::output::{Output, Tone, plain};

/// An adapter with the limits that the runtime can use, and its self-check, or why there is none.
struct Examined {
    info: wgpu::AdapterInfo,
    limits: wgpu::Limits,
    check: Result<SelfCheck, String>,
}

/// A backend, its adapter in words, and the reason.
struct Choice {
    backend: &'static str,
    adapter: Option<String>,
    reason: String,
}

/// Runs it.
pub fn run(_: &DoctorArgs, out: &Output) -> Result<Exit, Failure> {
    let adapters = pollster::block_on(wgpu::Instance::default().enumerate_adapters(wgpu::Backends::all()));
    let examined: Vec<_> = adapters.iter().map(examine).collect();
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let (auto, gpu) = choices(threads);
    let failed = examined.iter().filter(|e| e.check.as_ref().is_ok_and(|c| !c.passed()));
    for adapter in failed.clone() {
        let text = format!("{} failed its self-check: update its driver", adapter.info.name);
        out.remark(Tone::Warning, "warning", &text);
    }
    let exit = if failed.count() > 0 { Exit::Findings } else { Exit::Done };
    if out.json {
        let adapters: Vec<_> = examined.iter().map(as_json).collect();
        let choice = |c: &Choice| json!({"backend": c.backend, "adapter": c.adapter, "reason": c.reason});
        out.json(&json!({"adapters": adapters, "cpu_threads": threads, "auto": choice(&auto),
                         "gpu": gpu.as_ref().map_or(Value::Null, choice), "exit": exit.code()}))?;
        return Ok(exit);
    }
    let mut text = String::new();
    if examined.is_empty() {
        text += "no GPU adapter: no Vulkan, Metal, Direct3D 12 or OpenGL driver was found\n\n";
    }
    for adapter in &examined {
        text += &in_words(adapter);
        text.push('\n');
    }
    text += &format!("--backend auto   {}\n", sentence(&auto));
    text += &match &gpu {
        Some(gpu) => format!("--backend gpu    {}\n", sentence(gpu)),
        None => "--backend gpu    ends with an error: there is no GPU\n".into(),
    };
    text += &format!("--backend cpu    the CPU, {threads} threads\n");
    out.data(&text)?;
    Ok(exit)
}

fn examine(adapter: &wgpu::Adapter) -> Examined {
    let check = Device::of(adapter).map(|device| device.check());
    Examined { info: adapter.get_info(), limits: adapter.limits(), check }
}

/// The adapter that `--backend auto` and, if there is any, `--backend gpu` take.
fn choices(threads: usize) -> (Choice, Option<Choice>) {
    let cpu = |reason: String| Choice { backend: "cpu", adapter: None, reason: format!("{threads} threads: {reason}") };
    let device = match Device::fastest() {
        Ok(device) => device,
        Err(words) => {
            // wgpu lists everything that it looked for.
            let first = words.split(';').next().unwrap_or_default().to_owned();
            return (cpu(first), None);
        }
    };
    let check = device.check();
    let name = Some(device.info.name.clone());
    let passed = if check.passed() { "it passed its self-check" } else { "although it failed its self-check" };
    let gpu = Choice { backend: "gpu", adapter: name.clone(), reason: passed.into() };
    let auto = if device.is_software() {
        cpu("the fastest adapter is a software adapter, and the CPU backend is faster".into())
    } else if check.passed() {
        Choice { backend: "gpu", adapter: name, reason: passed.into() }
    } else {
        cpu(format!("{} failed its self-check", device.info.name))
    };
    (auto, Some(gpu))
}

fn sentence(choice: &Choice) -> String {
    match &choice.adapter {
        Some(name) => format!("{} ({})", plain(name), choice.reason),
        None => format!("the CPU, {}", plain(&choice.reason)),
    }
}

/// The limits that decide how cloth runs: name, unit of the JSON key, value.
fn limits(limits: &wgpu::Limits) -> [(&'static str, u64); 5] {
    [
        ("workgroup_memory_bytes", limits.max_compute_workgroup_storage_size.into()),
        ("workgroup_threads", limits.max_compute_invocations_per_workgroup.into()),
        ("storage_buffers", limits.max_storage_buffers_per_shader_stage.into()),
        ("binding_bytes", limits.max_storage_buffer_binding_size),
        ("buffer_bytes", limits.max_buffer_size),
    ]
}

fn kind(info: &wgpu::AdapterInfo) -> &'static str {
    match info.device_type {
        wgpu::DeviceType::DiscreteGpu => "discrete GPU",
        wgpu::DeviceType::IntegratedGpu => "integrated GPU",
        wgpu::DeviceType::VirtualGpu => "virtual GPU",
        wgpu::DeviceType::Cpu => "software",
        wgpu::DeviceType::Other => "unknown",
    }
}

fn driver(info: &wgpu::AdapterInfo) -> String {
    [info.driver.trim(), info.driver_info.trim()].join(" ").trim().to_owned()
}

fn in_words(adapter: &Examined) -> String {
    let Examined { info, limits: have, check } = adapter;
    let mut text = format!("{}\n", plain(&info.name));
    let mut line = |name: &str, value: &str| {
        // A String takes everything.
        let _ = writeln!(text, "  {name:<24} {}", plain(value).replace('\n', " "));
    };
    line("interface", &info.backend.to_string());
    line("driver", &driver(info));
    line("kind", kind(info));
    limits(have).iter().for_each(|(name, value)| line(&name.replace('_', " "), &value.to_string()));
    match check {
        Err(words) => line("self-check", &format!("not run: {words}")),
        Ok(check) if check.passed() => line("self-check", &format!("passed in {:.0} ms", check.ms)),
        Ok(check) => {
            line("self-check", &format!("FAILED in {:.0} ms", check.ms));
            check.mismatches.iter().for_each(|m| line("", &m.to_string()));
        }
    }
    text
}

fn as_json(adapter: &Examined) -> Value {
    let Examined { info, limits: have, check } = adapter;
    let limits: serde_json::Map<_, _> = limits(have).iter().map(|(n, v)| ((*n).to_owned(), json!(v))).collect();
    let (check, error) = match check {
        Ok(c) => {
            let mismatches: Vec<_> = c.mismatches.iter().map(Mismatch::to_string).collect();
            (json!({"passed": c.passed(), "ms": c.ms, "mismatches": mismatches}), Value::Null)
        }
        Err(words) => (Value::Null, json!(words)),
    };
    json!({"name": info.name, "interface": info.backend.to_string(), "driver": driver(info), "kind": kind(info),
           "limits": limits, "self_check": check, "error": error})
}
