//! A scan of a skull.

use std::path::Path;

use isoray_build::{Isovalues, Loss, SurfaceTolerance};
use isoray_oracle::{DenseLattice, OracleRay, all_hits};
use isoray_trace::{Ray, Tracer};

use super::common::{lose, octree, widened};
use super::displacement::is_near;

const SIZE: [u32; 3] = [256, 256, 108];
const ISOVALUE: f32 = 300.0;

/// Rays along z, through points between samples.
fn rays() -> impl Iterator<Item = Ray> {
    (0..128 * 128).map(|n: u32| Ray {
        origin: [(n % 128) as f32 * 1.9 + 0.3, (n / 128) as f32 * 1.9 + 0.7, -1.0],
        direction: [0.0, 0.0, 1.0],
        t_min: 0.0,
        t_max: f32::INFINITY,
    })
}

/// Every 7th ray's hits with either surface, by the oracle, have the other one near.
fn check_displacement(before: &[i16], after: &[i16], bound: f64) {
    let [a, b] = [before, after].map(|s| DenseLattice::from_vec(SIZE, widened(s)).unwrap());
    let v = ISOVALUE.into();
    for ray in rays().step_by(7) {
        let Ray { origin, direction, t_min, t_max } = ray;
        let ray = OracleRay { origin, direction, t_min, t_max };
        for (on, other) in [(&a, &b), (&b, &a)] {
            for hit in all_hits(on, &ray, v) {
                assert!(is_near(&hit, on, other, v, bound), "{ray:?} {hit:?}");
            }
        }
    }
}

#[test]
fn a_skull_is_kept_as_promised() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data/volumes/cranium/cranium_256x256x108_i16le.raw");
    let Ok(bytes) = std::fs::read(&file) else {
        return println!("SKIPPED: there is no {}", file.display());
    };
    let before: Vec<i16> = bytes.as_chunks().0.iter().map(|&b| i16::from_le_bytes(b)).collect();
    let lossless = octree(SIZE, &before);
    let surface = |displacement| {
        let isovalues = Isovalues::List(vec![ISOVALUE]);
        Loss { surface: Some(SurfaceTolerance { displacement, isovalues }), ..Loss::default() }
    };
    let tolerance = Loss { tolerance: 20.0, ..Loss::default() };
    let range = Loss { range: Some([250.0, 350.0]), ..Loss::default() };
    let cases = [
        ("tolerance 20", tolerance, None),
        ("range 250 to 350", range, Some(0.0)),
        ("exact", surface(0.0), Some(0.0)),
        ("half a voxel", surface(0.5), Some(0.5)),
    ];
    for (name, loss, bound) in cases {
        let (after, changes) = lose(SIZE, &before, &loss);
        let lossy = octree(SIZE, &after);
        let percent = |bytes: usize| 100.0 * bytes as f64 / lossless.raw_bytes() as f64;
        println!(
            "{name}: {:.1} instead of {:.1} % of the raw samples, {changes:?}",
            percent(lossy.file_bytes()),
            percent(lossless.file_bytes())
        );
        assert!(lossy.file_bytes() < lossless.file_bytes() && changes.samples > 0);
        if loss.tolerance.is_finite() {
            assert!(before.iter().zip(&after).all(|(a, b)| f64::from(a.abs_diff(*b)) <= loss.tolerance));
        }
        let views = [lossless.view(), lossy.view()];
        let [mut first, mut second] = [Tracer::new(&views[0]), Tracer::new(&views[1])];
        let mut hits = 0;
        for ray in rays() {
            let [a, b] = [first.first_hit(&ray, ISOVALUE), second.first_hit(&ray, ISOVALUE)];
            hits += u32::from(a.is_some());
            if bound == Some(0.0) {
                assert_eq!(a, b, "{name}: {ray:?}");
            }
        }
        if let Some(bound) = bound {
            check_displacement(&before, &after, bound);
        }
        assert!(hits > 3000, "too few hits to mean anything: {hits}");
    }
}
