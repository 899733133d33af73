//! A mesh of one level against the structured volume of the same values.

use glam::DAffine3;
use isoray_amr::{Centering, Mesh, MeshOptions, MeshTracer, MeshVolumeTracer, Patch, Patches};
use isoray_build::build;
use isoray_grid::{DenseVolume, Dims};
use isoray_oracle::{LatticeKind, RayKind, adversarial_isovalue, adversarial_transfer};
use isoray_preint::{Bounded, Visibility};
use isoray_trace::{CountHits, Trace, Tracer, VolumeTracer};

use crate::rays::{function, ray, shading};

/// Samples along each axis: of more blocks of 4³ than one, and no whole number of them.
const DIMS: [u32; 3] = [11, 6, 14];

/// One patch with values at vertices.
fn mesh(values: &[f32]) -> Mesh {
    let cells = DIMS.map(|n| n - 1);
    let patches = Patches {
        centering: Centering::Vertices,
        ratios: Vec::new(),
        index_to_world: DAffine3::IDENTITY,
        domain: ([0; 3], cells),
        patches: vec![Patch { level: 0, low: [0; 3], cells, values: values.to_vec().into() }],
    };
    Mesh::new(&patches, MeshOptions::default()).unwrap()
}

#[test]
fn hits_are_those_of_the_structured_volume() {
    let (mut hits, mut crossings) = (0, 0);
    for kind in LatticeKind::ALL {
        for seed in 0..12 {
            let values = kind.generate(DIMS, seed);
            let mesh = mesh(&values);
            let mut source = DenseVolume::new(Dims::new(DIMS).unwrap(), &values).unwrap();
            let octree = build(&mut source, DAffine3::IDENTITY, |_| {}).unwrap();
            let view = octree.view();
            let (mut of_mesh, mut of_octree) = (MeshTracer::new(&mesh), Tracer::new(&view));
            let isovalue = adversarial_isovalue(&values, seed);
            for ray_kind in RayKind::ALL {
                for n in 0..20 {
                    let ray = ray(&ray_kind.generate(DIMS, seed.wrapping_mul(1000) + n));
                    let found = of_mesh.first_hit(&ray, isovalue);
                    let expected = of_octree.first_hit(&ray, isovalue);
                    assert_eq!(found, expected, "{kind:?} {seed} {ray_kind:?} {n}, isovalue {isovalue}");
                    let [mut all, mut all_expected] = [CountHits::default(), CountHits::default()];
                    of_mesh.trace(&ray, isovalue, &mut all, &mut ());
                    of_octree.trace(&ray, isovalue, &mut all_expected, &mut ());
                    assert_eq!(all.0, all_expected.0, "{kind:?} {seed} {ray_kind:?} {n}");
                    hits += u32::from(found.is_some());
                    crossings += all.0;
                }
            }
        }
    }
    assert!(hits > 1000 && crossings > 2000, "{hits} hits, {crossings} crossings");
}

#[test]
fn integrals_are_those_of_the_structured_volume() {
    let (mut rays, mut lit) = (0, 0);
    for kind in LatticeKind::ALL {
        for seed in 0..8 {
            let values = kind.generate(DIMS, seed);
            let mesh = mesh(&values);
            let Some([low, high]) = mesh.range() else { continue };
            let points = adversarial_transfer(seed, [low, high]);
            let Some(transfer) = function(&points) else { continue };
            let mut source = DenseVolume::new(Dims::new(DIMS).unwrap(), &values).unwrap();
            let octree = build(&mut source, DAffine3::IDENTITY, |_| {}).unwrap();
            let (view, visible) = (octree.view(), Visibility::new(&transfer));
            let mut of_mesh = MeshVolumeTracer::new(&mesh, &visible);
            let mut of_octree = VolumeTracer::new(&view, &visible);
            let is_lit = seed % 2 == 1 && high > low && high - low < 1e6;
            let lighting = is_lit.then(|| shading(high - low).1);
            let brightest = lighting.as_ref().map_or(1.0, |lighting| lighting.brightest(high - low));
            for epsilon in [1.0 / 64.0, 1e-4] {
                let scheme = Bounded::new(&transfer, epsilon, brightest);
                for ray_kind in RayKind::ALL {
                    for n in 0..6 {
                        let ray = ray(&ray_kind.generate(DIMS, seed.wrapping_mul(1000) + n));
                        let found = of_mesh.integrate(&ray, 0.3, &scheme, lighting.as_ref(), &mut ());
                        let expected = of_octree.integrate(&ray, 0.3, &scheme, lighting.as_ref(), &mut ());
                        let apart = (0..3).map(|n| (found.color[n] - expected.color[n]).abs());
                        let apart = apart.fold((found.alpha() - expected.alpha()).abs(), f64::max);
                        // Each is within its bound of the truth.
                        assert!(apart <= 2.0 * epsilon, "{apart}: {kind:?} {seed} {ray_kind:?} {n}");
                        rays += 1;
                        lit += u32::from(found.alpha() > 0.0);
                    }
                }
            }
        }
    }
    assert!(lit * 4 > rays, "{lit} lit of {rays}");
}
