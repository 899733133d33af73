//! Volumes to build of, and what their builds give.

use std::io::Write;
use std::path::PathBuf;
use std::process::Child;
use std::time::Duration;

use flate2::Compression;
use flate2::write::GzEncoder;

use crate::sandbox::Sandbox;

/// An NRRD file; with `gzip` its samples are in a stream that has to be read in order.
pub(crate) fn nrrd(size: [usize; 3], sample: &str, samples: &[u8], gzip: Option<Compression>) -> Vec<u8> {
    let encoding = if gzip.is_some() { "gzip" } else { "raw" };
    let [x, y, z] = size;
    let header = format!(
        "NRRD0004\ntype: {sample}\ndimension: 3\nsizes: {x} {y} {z}\nendian: little\nencoding: {encoding}\n\n"
    );
    let Some(level) = gzip else { return [header.as_bytes(), samples].concat() };
    let mut stream = GzEncoder::new(header.into_bytes(), level);
    stream.write_all(samples).unwrap();
    stream.finish().unwrap()
}

/// Bytes that are noise here and all alike there.
pub(crate) fn noise(count: usize, seed: u32) -> Vec<u8> {
    let mut state = seed;
    let mut byte = |n: usize| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        if n / 4096 % 4 == 3 { 9 } else { (state >> 24) as u8 }
    };
    (0..count).map(&mut byte).collect()
}

/// The least limit that a build takes, as its refusal tells.
pub(crate) fn least(sandbox: &Sandbox, line: &str) -> u64 {
    let outcome = sandbox.line(&format!("{line} --memory 1"));
    assert_eq!(outcome.code, 1, "{outcome:?}");
    let (_, rest) = outcome.stderr.split_once("needs at least ").unwrap_or_else(|| panic!("{outcome:?}"));
    rest.split(' ').next().unwrap().parse().unwrap()
}

/// The bytes that a build gives; its output is removed.
pub(crate) fn built(sandbox: &Sandbox, line: &str, output: &str) -> Vec<u8> {
    sandbox.succeeds(line);
    let bytes = sandbox.read(output);
    std::fs::remove_file(sandbox.path(output)).unwrap();
    bytes
}

/// Whether a name is that of an unfinished file.
pub(crate) fn is_part(name: &str) -> bool {
    name.ends_with(".isoray-part")
}

/// Waits until a build has begun to write, and says where to; nothing if it has ended before that was seen.
pub(crate) fn wait_for_part(sandbox: &Sandbox, child: &mut Child) -> Option<PathBuf> {
    loop {
        let ended = child.try_wait().unwrap().is_some();
        if let Some(name) = sandbox.names().into_iter().find(|name| is_part(name)) {
            return Some(sandbox.path(&name));
        }
        if ended {
            return None;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}
