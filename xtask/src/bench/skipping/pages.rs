//! Pages of a mapped file that a picture does not need.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use isoray_grid::Scalar;
use isoray_octree::{AnyVolume, NODE_LEVEL, OctreeVolume, VolumeVisitor};
use isoray_render::{Camera, Image, Scene, render};

use super::{Per, Setting, SkippingRow};
use crate::bench::picture::hits;
use crate::bench::timer::interleave_kept;
use crate::catalog::{Dense, Place};

/// Pages of a file that are mapped in one piece as a rule, and how many such pieces a file must have for some to be left out for sure.
const AT_ONCE: f64 = 16.0;
const PIECES: f64 = 64.0;

pub(super) fn measure<T: Scalar + Into<f64>>(
    setting: Setting<'_>,
    volume: &Dense<T>,
    octree: &OctreeVolume<T>,
) -> Result<Vec<SkippingRow>> {
    let name = &setting.entry.name;
    let size = setting.size(96, 256);
    let folder = tempfile::tempdir().context("no temporary folder")?;
    let path = &folder.path().join("volume.ovol");
    octree.save(path)?;
    let camera = volume.camera(Place::Close, size)?;
    let isovalue = setting.entry.isovalues[0];
    let expected = render(&octree.view(), volume.index_to_world, &camera, &Scene::of(isovalue));
    ensure!(hits(&expected) > 0, "{name}, close: no ray hits");
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().context("cannot start a thread")?;
    let show = |reads_all, is_counted| {
        let show = Show { path, camera: &camera, isovalue, reads_all, is_counted };
        one.install(|| AnyVolume::open(path)?.visit(show))
    };
    let (with, mapped) = show(false, true)?;
    let (without, all_mapped) = show(true, true)?;
    ensure!(with == expected && without == expected, "{name}: the mapped file shows another picture");
    let [Some(mapped), Some(all_mapped)] = [mapped, all_mapped] else {
        println!("SKIPPED: pages that are not needed; this system does not tell which are mapped");
        return Ok(Vec::new());
    };
    let file = octree.file_bytes() as f64 / 1024.0;
    if file < PIECES * AT_ONCE * mapped.page {
        println!("SKIPPED: pages that are not needed; {name} has so few that all may be mapped");
        return Ok(Vec::new());
    }
    let (times, timed) =
        interleave_kept(setting.repeat, &mut [&mut || show(false, false), &mut || show(true, false)]);
    for image in timed {
        ensure!(image?.0 == expected, "{name}: the mapped file shows another picture when timed");
    }
    let ns = [times[0], times[1]].map(|seconds| seconds * 1e9 / f64::from(size).powi(2));
    let kilobytes = [mapped.kilobytes, all_mapped.kilobytes];
    let counts = [
        ("KB mapped by the kernel, in all", kilobytes),
        ("% of the file", kilobytes.map(|kb| 100.0 * kb / file)),
    ];
    Ok(vec![setting.row(["surface close, opened", "pages never touched"], Per::Ray, ns, &counts).spared()?])
}

/// A picture of a file that is opened for it.
struct Show<'a> {
    path: &'a Path,
    camera: &'a Camera,
    isovalue: f32,
    /// Reads all samples first, as from a file that is not mapped.
    reads_all: bool,
    /// Looks up what is mapped in the end, which takes a while.
    is_counted: bool,
}

impl VolumeVisitor for Show<'_> {
    /// The picture, and how much of the file is mapped then, if that is asked for and known.
    type Output = Result<(Image, Option<Mapped>)>;

    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> Self::Output {
        let view = volume.view();
        if self.reads_all {
            std::hint::black_box(view.caps().iter().fold(0u8, |all, byte| all ^ byte));
            let levels = NODE_LEVEL..=view.root_level();
            let masks = levels.flat_map(|level| view.nodes(level)).fold(0, |all, node| all ^ node.mask);
            std::hint::black_box(masks);
        }
        let image = render(&view, volume.meta().index_to_world, self.camera, &Scene::of(self.isovalue));
        Ok((image, if self.is_counted { mapped(self.path) } else { None }))
    }
}

/// How much of a file is mapped into this process, in kilobytes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Mapped {
    kilobytes: f64,
    /// A page.
    page: f64,
}

/// What the kernel has mapped of the file at `path`; where Linux tells it.
///
/// That is not what was touched but more: with a page that is touched it maps those around it that are in the cache, sixteen as a rule.
fn mapped(path: &Path) -> Option<Mapped> {
    let maps = std::fs::read_to_string("/proc/self/smaps").ok()?;
    mapped_in(&maps, path.to_str()?)
}

/// The sum over all mappings of the file in the text of `smaps`.
fn mapped_in(maps: &str, path: &str) -> Option<Mapped> {
    let mut sum: Option<Mapped> = None;
    let mut page = f64::NAN;
    let mut is_of_file = false;
    for line in maps.lines() {
        let Some((key, rest)) = line.split_once(':').filter(|(key, _)| !key.contains(' ')) else {
            is_of_file = line.ends_with(path);
            continue;
        };
        if !is_of_file || !matches!(key, "KernelPageSize" | "Rss") {
            continue;
        }
        let kilobytes: f64 = rest.trim().strip_suffix("kB")?.trim().parse().ok()?;
        match key {
            // Comes first.
            "KernelPageSize" => page = kilobytes,
            _ => sum = Some(Mapped { kilobytes: sum.map_or(0.0, |sum| sum.kilobytes) + kilobytes, page }),
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mappings_of_the_file_alone_are_summed() {
        const MAPS: &str = "\
7f00-7f80 r--p 00000000 fe:00 12    /a/volume.ovol
Size:                512 kB
KernelPageSize:        4 kB
Rss:                 128 kB
7f80-7f90 r--p 00000000 fe:00 13    /a/other
KernelPageSize:     2048 kB
Rss:                  64 kB
7f90-7fa0 r--s 00080000 fe:00 12    /a/volume.ovol
KernelPageSize:        4 kB
Rss:                   4 kB
VmFlags: rd mr mw me
7fb0-7fc0 rw-p 00000000 00:00 0
KernelPageSize:        4 kB
Rss:                   8 kB";
        assert_eq!(mapped_in(MAPS, "/a/volume.ovol"), Some(Mapped { kilobytes: 132.0, page: 4.0 }));
        assert_eq!(mapped_in(MAPS, "/a/none"), None);
        assert_eq!(mapped_in("", "/a/volume.ovol"), None);
    }
}
