//! Rays that start on a surface, in packets and alone.

use isoray_oracle::SplitMix64;
use isoray_packet::{Slicing, TracePackets, Traversal};
use isoray_trace::{DepartingRay, Hit, Trace};

/// Sends rays from hits to a light, the same way, and anywhere, in packets and alone; how many of them are occluded.
pub(crate) fn compare(
    packets: &mut impl TracePackets,
    single: &mut impl Trace,
    hits: &[Hit],
    isovalue: f32,
    random: &mut SplitMix64,
) -> usize {
    let mut anywhere = || [(); 3].map(|()| random.range(-40.0, 40.0) as f32);
    let light = anywhere();
    let mut number_occluded = 0;
    for kind in 0..3 {
        let ray = |hit: &Hit, own: [f32; 3]| {
            let position = hit.position();
            let to_light = std::array::from_fn(|a| light[a] - position[a] as f32);
            let (direction, t_max) = match kind {
                0 => (to_light, 1.0),
                1 => (light, f32::INFINITY),
                _ => (own, f32::INFINITY),
            };
            // Also rays to the back of the surface, and to the wrong side.
            hit.departing_ray(direction, t_max, !hit.is_entering ^ (own[0] > 35.0))
        };
        let rays: Vec<DepartingRay> = hits.iter().map(|hit| ray(hit, anywhere())).collect();
        let mut occluded = vec![true; rays.len()];
        let traversal = if kind == 2 && rays.len().is_multiple_of(2) {
            Traversal::Coherent(Slicing::default())
        } else {
            Traversal::Masked
        };
        packets.occluded_all(&rays, isovalue, traversal, &mut occluded, &mut ());
        for (ray, &found) in rays.iter().zip(&occluded) {
            assert_eq!(found, single.occluded(ray, isovalue, &mut ()), "{ray:?}, isovalue {isovalue}");
        }
        number_occluded += occluded.iter().filter(|&&is_occluded| is_occluded).count();
    }
    number_occluded
}
