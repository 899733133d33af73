//! The rules of ties, touches, borders, empty cells and bad input, one by one.

use isoray_oracle::{DenseLattice, FnLattice, OracleRay, all_hits, first_hit, judge};

fn ray(origin: [f32; 3], direction: [f32; 3]) -> OracleRay {
    OracleRay { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
}

/// A lattice that varies along x only.
fn along_x(samples: &[f64]) -> FnLattice<impl Fn([u32; 3]) -> f64 + Sync + '_> {
    FnLattice::new([samples.len() as u32, 3, 3], |p| samples[p[0] as usize])
}

/// Hits of a ray along +x as pairs of `x` and `entering`.
fn crossings(samples: &[f64], v: f64) -> Vec<(f64, bool)> {
    let hits = all_hits(&along_x(samples), &ray([-3.0, 0.4, 1.7], [1.0, 0.0, 0.0]), v);
    hits.iter().map(|h| (h.position[0], h.entering)).collect()
}

#[test]
fn a_plateau_at_the_isovalue_is_inside_and_its_rims_are_the_surface() {
    assert_eq!(crossings(&[0.0, 3.0, 3.0, 3.0, 1.0], 3.0), [(1.0, true), (3.0, false)]);
    assert_eq!(crossings(&[5.0, 3.0, 3.0, 5.0], 3.0), [], "it never leaves the inside");
    assert_eq!(crossings(&[0.0, 3.0, 3.0, 5.0], 3.0), [(1.0, true)]);
    assert_eq!(crossings(&[3.0, 3.0, 3.0], 3.0), [], "a constant volume has no surface");
}

#[test]
fn a_hit_on_a_face_belongs_to_the_cell_outside() {
    let samples = [0.0, 3.0, 3.0, 0.0];
    let hits = all_hits(&along_x(&samples), &ray([-1.0, 0.5, 0.5], [2.0, 0.0, 0.0]), 3.0);
    assert_eq!(hits.iter().map(|h| h.cell[0]).collect::<Vec<_>>(), [0, 2]);
    assert_eq!(hits.iter().map(|h| h.gradient[0]).collect::<Vec<_>>(), [3.0, -3.0]);
}

#[test]
fn a_hit_on_a_face_is_exactly_there_whatever_the_rounding() {
    let samples = [0.0, 0.0, 3.0, 3.0, 3.0, 0.0];
    for k in 1..500_u16 {
        let step = f32::from(k) / 700.0;
        let through = ray([-1.3 - step, 0.4, 1.7], [0.1 + step, step * 1e-3, -step * 1e-3]);
        let hits = all_hits(&along_x(&samples), &through, 3.0);
        assert_eq!(hits.iter().map(|h| h.position[0]).collect::<Vec<_>>(), [2.0, 4.0], "{through:?}");
        let (o, d) = (f64::from(through.origin[0]), f64::from(through.direction[0]));
        assert_eq!(hits.iter().map(|h| h.t).collect::<Vec<_>>(), [(2.0 - o) / d, (4.0 - o) / d]);
    }
}

#[test]
fn touches_are_no_hits_and_passages_through_a_face_are_one() {
    assert_eq!(crossings(&[0.0, 3.0, 0.0], 3.0), [], "a peak that reaches the isovalue");
    assert_eq!(crossings(&[6.0, 3.0, 6.0], 3.0), [], "a valley that reaches it");
    assert_eq!(crossings(&[0.0, 3.0, 6.0], 3.0), [(1.0, true)]);
    assert_eq!(crossings(&[6.0, 3.0, 0.0], 3.0), [(1.0, false)]);
    assert_eq!(crossings(&[0.0, 3.0], 3.0), [], "reached where the domain ends");
}

#[test]
fn a_touch_inside_a_cell_is_no_hit() {
    // A saddle that along the diagonal of the face z = 0 is (2u - 1)².
    let saddle = FnLattice::new([2, 2, 2], |p| if (p[0] + p[1]) % 2 == 0 { 1.0 } else { -1.0 });
    let diagonal = ray([0.0; 3], [1.0, 1.0, 0.0]);
    assert_eq!(all_hits(&saddle, &diagonal, 0.0), []);
    assert!(judge(&saddle, &diagonal, 0.0).grazing);
    assert_eq!(all_hits(&saddle, &diagonal, 0.25).len(), 2);
}

#[test]
fn starts_and_borders_are_no_hits() {
    let volume = along_x(&[5.0, 5.0, 0.0, 0.0]);
    let inside = ray([0.25, 1.0, 1.0], [1.0, 0.0, 0.0]);
    let hit = first_hit(&volume, &inside, 2.5).expect("the way out");
    assert_eq!((hit.position[0], hit.entering), (1.5, false));
    assert_eq!(first_hit(&volume, &ray([1.75, 1.0, 1.0], [1.0, 0.0, 0.0]), 2.5), None);
    assert_eq!(first_hit(&volume, &ray([-1.0, 1.0, 1.0], [0.0, 1.0, 0.0]), 2.5), None);

    let clipped = |t_min, t_max| first_hit(&volume, &OracleRay { t_min, t_max, ..inside }, 2.5);
    assert!(clipped(0.0, 1.25).is_none() && clipped(1.25, 9.0).is_none(), "the clip is no hit");
    assert!(clipped(0.0, 1.5).is_some() && clipped(1.0, 9.0).is_some());
    assert!(clipped(f32::NEG_INFINITY, f32::INFINITY).is_some());
    assert!(clipped(2.0, 1.0).is_none());
}

#[test]
fn the_hit_is_the_first_whichever_way_the_ray_goes() {
    let samples = [0.0, 4.0, 0.0, 4.0, 0.0];
    assert_eq!(crossings(&samples, 1.0), [(0.25, true), (1.75, false), (2.25, true), (3.75, false)]);
    let back = first_hit(&along_x(&samples), &ray([9.0, 1.0, 1.0], [-2.0, 0.0, 0.0]), 1.0);
    assert_eq!(back.map(|h| (h.t, h.position[0], h.entering)), Some((2.625, 3.75, true)));
}

#[test]
fn a_ray_in_a_lattice_plane_takes_the_cell_above_it() {
    // One huge sample at the far end of y tells the layers of cells apart where it is not finite.
    let volume = FnLattice::new([3, 3, 3], |p| if p[1] == 2 { f64::NAN } else { f64::from(p[0]) });
    let at = |y: f32| first_hit(&volume, &ray([-1.0, y, 0.5], [1.0, 0.0, 0.0]), 0.5);
    assert_eq!(at(0.0).map(|h| (h.t, h.cell)), Some((1.5, [0, 0, 0])));
    assert_eq!(at(1.0), None, "in plane 1: cells of layer 1, which are empty");

    let sound = FnLattice::new([3, 3, 3], |p| f64::from(p[0]));
    let border = first_hit(&sound, &ray([-1.0, 2.0, 2.0], [1.0, -0.0, 0.0]), 0.5);
    assert_eq!(border.map(|h| (h.t, h.cell)), Some((1.5, [0, 1, 1])), "in the last plane: the last layer");
}

#[test]
fn rays_in_faces_and_through_vertices_hit_once() {
    let volume = FnLattice::new([5, 5, 5], |p| f64::from(p[0] + p[1] + p[2]));
    for v in [1.0, 2.0, 2.5, 3.0, 4.0, 6.0] {
        let diagonal = all_hits(&volume, &ray([-1.0; 3], [1.0; 3]), v);
        assert_eq!(diagonal.len(), 1);
        assert!((diagonal[0].t - (1.0 + v / 3.0)).abs() < 1e-15);
        let in_face = all_hits(&volume, &ray([-2.0, -2.0, 0.0], [1.0, 1.0, -0.0]), v);
        assert_eq!(in_face.iter().map(|h| h.t).collect::<Vec<_>>(), [2.0 + v / 2.0]);
    }
}

#[test]
fn cells_with_a_missing_corner_are_empty_and_restart_the_state() {
    let samples = [0.0, 1.0, f64::NAN, 9.0, 9.0, 0.0];
    assert_eq!(crossings(&samples, 5.0), [(4.0 + 4.0 / 9.0, false)], "the jump over the gap is no hit");
    for missing in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(crossings(&[0.0, missing, 9.0], 5.0), []);
    }
}

#[test]
fn thin_lattices_have_no_cells() {
    for dims in [[1, 4, 4], [4, 1, 4], [4, 4, 1], [1, 1, 1], [0, 4, 4], [0, 0, 0]] {
        let volume = DenseLattice::from_fn(dims, |p| (p[0] + p[1] + p[2]) as f32);
        assert_eq!(all_hits(&volume, &ray([-1.0; 3], [1.0; 3]), 1.5), []);
        assert_eq!(all_hits(&volume, &ray([0.0; 3], [0.0, 0.0, 1.0]), 1.5), []);
    }
}

#[test]
fn bad_rays_and_isovalues_hit_nothing() {
    let volume = along_x(&[0.0, 1.0, 2.0]);
    let good = ray([-1.0, 1.0, 1.0], [1.0, 0.0, 0.0]);
    assert!(first_hit(&volume, &good, 0.5).is_some());
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert!(first_hit(&volume, &ray([bad, 1.0, 1.0], good.direction), 0.5).is_none());
        assert!(first_hit(&volume, &ray(good.origin, [1.0, bad, 0.0]), 0.5).is_none());
        assert!(first_hit(&volume, &good, f64::from(bad)).is_none());
    }
    assert!(first_hit(&volume, &OracleRay { t_min: f32::NAN, ..good }, 0.5).is_none());
    assert!(first_hit(&volume, &OracleRay { t_max: f32::NAN, ..good }, 0.5).is_none());
    assert!(first_hit(&volume, &ray(good.origin, [0.0, -0.0, 0.0]), 0.5).is_none());
    assert!(DenseLattice::from_vec([2, 2, 2], vec![0_u8; 7]).is_none());
}

#[test]
fn denormal_directions_reach_as_far_as_any() {
    let volume = along_x(&[0.0, 1.0, 2.0]);
    let smallest = f32::from_bits(1);
    let hit = first_hit(&volume, &ray([0.0, 1.0, 1.0], [smallest, 0.0, 0.0]), 0.5).expect("far in t");
    assert!((hit.t * f64::from(smallest) - 0.5).abs() < 1e-15);
    let leaning = first_hit(&volume, &ray([-1.0, 1.0, 1.0], [1.0, smallest, -1e-38]), 0.5);
    assert_eq!(leaning.map(|h| h.t), Some(1.5));
}

#[test]
fn the_judge_flags_what_hangs_on_a_rounding_error_and_nothing_else() {
    let peak = [0.0, 100.0, 0.0];
    let volume = along_x(&peak);
    let along = ray([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0]);
    let generic = judge(&volume, &along, 50.0);
    assert!(!generic.grazing && generic.tested == 1);
    assert_eq!(generic.hit.map(|h| h.t), Some(1.5));
    assert!(judge(&volume, &along, 100.0).grazing, "the peak just touches");
    assert!(judge(&volume, &along, 99.999_99).grazing, "the peak just reaches through");
    assert!(!judge(&volume, &along, 99.9).grazing);
    let missed = judge(&volume, &along, 101.0);
    assert!(!missed.grazing && missed.tested == 0 && missed.hit.is_none());

    // A ray that slides along the surface y = 1: hit or not, a little up or down changes where.
    let sheet = FnLattice::new([9, 3, 3], |p| f64::from(p[1]));
    let sliding = ray([-1.0, 1.0 - 1e-7, 0.5], [1.0, 1e-7, 0.0]);
    assert!(judge(&sheet, &sliding, 1.0).grazing);
}
