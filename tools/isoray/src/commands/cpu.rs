//! `isoray info --cpu`.

use std::io::Write;

use anyhow::Result;
use isoray_render::LANES;
use serde::Serialize;

use crate::output::to_stdout;

/// What the build uses of the processor, and what that has.
#[derive(Debug, Serialize)]
struct Cpu {
    architecture: &'static str,
    threads: usize,
    extensions: Vec<Extension>,
    /// Rays of packets that are intersected at once.
    lanes: usize,
}

#[derive(Debug, Serialize)]
struct Extension {
    name: &'static str,
    used: bool,
    offered: bool,
}

/// An extension by its name: whether the build uses it, and whether this machine has it.
macro_rules! extension {
    ($name:tt, $detected:ident) => {
        Extension { name: $name, used: cfg!(target_feature = $name), offered: std::arch::$detected!($name) }
    };
}

fn extensions() -> Vec<Extension> {
    #[cfg(target_arch = "x86_64")]
    return vec![
        extension!("sse4.2", is_x86_feature_detected),
        extension!("avx", is_x86_feature_detected),
        extension!("avx2", is_x86_feature_detected),
        extension!("fma", is_x86_feature_detected),
        extension!("bmi2", is_x86_feature_detected),
        extension!("avx512f", is_x86_feature_detected),
        extension!("avx512vl", is_x86_feature_detected),
        extension!("avx512bw", is_x86_feature_detected),
        extension!("avx512dq", is_x86_feature_detected),
    ];
    #[cfg(target_arch = "aarch64")]
    return vec![
        extension!("neon", is_aarch64_feature_detected),
        extension!("sve", is_aarch64_feature_detected),
    ];
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    Vec::new()
}

pub(crate) fn run(is_json: bool) -> Result<()> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let cpu = Cpu { architecture: std::env::consts::ARCH, threads, extensions: extensions(), lanes: LANES };
    to_stdout(|out| match is_json {
        true => {
            serde_json::to_writer_pretty(&mut *out, &cpu)?;
            writeln!(out)
        }
        false => write_text(out, &cpu),
    })
}

fn write_text(out: &mut dyn Write, cpu: &Cpu) -> std::io::Result<()> {
    writeln!(out, "architecture {}, {} threads", cpu.architecture, cpu.threads)?;
    let named = |of: &dyn Fn(&Extension) -> bool| {
        let names: Vec<_> = cpu.extensions.iter().filter(|e| of(e)).map(|e| e.name).collect();
        if names.is_empty() { "nothing beyond the architecture's own".to_owned() } else { names.join(" ") }
    };
    writeln!(out, "build uses   {}; packets of rays in {} lanes", named(&|e| e.used), cpu.lanes)?;
    writeln!(out, "machine has  {}", named(&|e| e.offered))?;
    if cpu.extensions.iter().any(|e| e.offered && !e.used) {
        writeln!(out, "A build on this machine, without RUSTFLAGS, would use all that it has.")?;
    }
    Ok(())
}
