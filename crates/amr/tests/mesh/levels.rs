//! Colours of levels.

use glam::DAffine3;
use isoray_amr::{Centering, Mesh, MeshOptions, MeshVolumeTracer, Patch, Patches};
use isoray_preint::{
    Bounded, ControlPoint, Cuts, Integrate, LinearPieces, Linearised, TransferFunction, Visibility,
};
use isoray_trace::Ray;

/// 8³ cells, of which 4³ in the middle are refined twice over; the values are those of x.
fn mesh() -> Mesh {
    let patch = |level: u32, low: i32, cells: u32| {
        let edge = 0.5f32.powi(level as i32);
        let x = |n: u32| (low as f32 + (n % cells) as f32 + 0.5) * edge;
        Patch {
            level,
            low: [low; 3],
            cells: [cells; 3],
            values: (0..cells.pow(3)).map(x).collect::<Vec<_>>().into(),
        }
    };
    let patches = Patches {
        centering: Centering::Cells,
        ratios: vec![2, 2],
        index_to_world: DAffine3::IDENTITY,
        domain: ([0; 3], [8; 3]),
        patches: vec![patch(0, 0, 8), patch(1, 4, 8), patch(2, 12, 8)],
    };
    Mesh::new(&patches, MeshOptions::default()).unwrap()
}

/// Along x.
const RAY: Ray =
    Ray { origin: [-1.0, 15.3, 16.6], direction: [1.0, 0.0, 0.0], t_min: 0.0, t_max: f32::INFINITY };

const COLORS: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.25, 1.0]];

fn haze(color: [f32; 3]) -> TransferFunction {
    let point = |value, extinction| ControlPoint { value, color, extinction };
    TransferFunction::new(vec![point(0.0, 0.06), point(8.0, 0.06)]).unwrap()
}

/// Of all that a ray gathers, colour and opacity.
fn gathered(scheme: &impl Integrate, colors: Option<&[[f32; 3]]>) -> ([f64; 3], f64) {
    let (mesh, transfer) = (mesh(), haze([1.0; 3]));
    let mut tracer = MeshVolumeTracer::new(&mesh, &Visibility::new(&transfer));
    let found = match colors {
        Some(colors) => tracer.integrate_levels(&RAY, 1.0, (scheme, colors), None, &mut ()),
        None => tracer.integrate(&RAY, 1.0, scheme, None, &mut ()),
    };
    (found.color, found.alpha())
}

#[test]
fn each_stretch_has_the_colour_of_its_cells() {
    const EPSILON: f64 = 1e-6;
    let scheme = Bounded::new(&haze([0.3; 3]).in_white(), EPSILON, 1.0);
    let (color, alpha) = gathered(&scheme, Some(&COLORS));
    // Lengths and exponents: cells, and beside finer ones parts of half their edge.
    let way = [(4.0, 2), (6.0, 1), (12.0, 0), (6.0, 1), (4.0, 2)];
    let mut expected = [0.0; 3];
    let mut transmittance = 1.0;
    for (length, exponent) in way {
        let behind = transmittance * f64::exp(-0.06 * length);
        for a in 0..3 {
            expected[a] += (transmittance - behind) * f64::from(COLORS[exponent][a]);
        }
        transmittance = behind;
    }
    assert!((alpha - (1.0 - transmittance)).abs() <= EPSILON);
    for a in 0..3 {
        assert!((color[a] - expected[a]).abs() <= EPSILON, "{color:?} {expected:?}");
    }
}

/// Colours and opacities of the transfer function change along the ray, which ends early.
#[test]
fn opacity_does_not_depend_on_them() {
    let point = |value, color, extinction| ControlPoint { value, color, extinction };
    let points = vec![
        point(1.0, [0.9, 0.2, 0.1], 0.0),
        point(3.0, [0.1, 0.8, 0.3], 0.4),
        point(4.5, [0.5; 3], 0.01),
        point(8.0, [0.2, 0.2, 0.9], 2.0),
    ];
    let transfer = TransferFunction::new(points).unwrap();
    let white = transfer.in_white();
    for cuts in [Cuts::Fixed(3), Cuts::Adaptive { inflection: true, shading: false }] {
        let scheme = |of| Linearised { cuts, pieces: LinearPieces::new(of), terminate: 0.01 };
        let (color, alpha) = gathered(&scheme(&white), Some(&COLORS));
        assert_eq!(alpha, gathered(&scheme(&transfer), None).1);
        assert!(alpha > 0.9 && alpha < 1.0 && color[1] > 0.0);
    }
    const EPSILON: f64 = 1e-3;
    let scheme = |of| Bounded::new(of, EPSILON, 1.0);
    let (color, alpha) = gathered(&scheme(&white), Some(&COLORS));
    // Where a ray ends depends on what its colours have cost.
    assert!((alpha - gathered(&scheme(&transfer), None).1).abs() <= EPSILON);
    // In white all of it is opacity.
    let (all, alpha_white) = gathered(&scheme(&white), Some(&[[1.0; 3]]));
    assert!((alpha - alpha_white).abs() < 1e-12 && (all[0] - alpha).abs() <= EPSILON);
    assert!((color[0] + color[1] + 0.75 * color[2] - all[0]).abs() < 1e-6, "{color:?} {all:?}");
}
