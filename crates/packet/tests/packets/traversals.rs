//! All ways of packets, and their hull.

use isoray_packet::{Slicing, Traversal};
use isoray_trace::{Beam, Ray};

/// One of them: of every ten, three are by slabs.
pub(crate) fn one_of(n: usize) -> Traversal {
    const STUDIED: [Slicing; 4] = [Slicing::Extents, Slicing::Kept, Slicing::Macrocells, Slicing::Active];
    match n % 10 {
        0 | 5 => Traversal::Auto,
        1 | 4 => Traversal::Coherent(Slicing::default()),
        7 => Traversal::Coherent(STUDIED[n / 10 % STUDIED.len()]),
        _ => Traversal::Masked,
    }
}

/// The hull of rays that run to one side along every axis.
pub(crate) fn hull(rays: &[Ray]) -> Option<Beam> {
    let backward = |ray: &Ray| (0..3).map(|a| u32::from(ray.direction[a] < 0.0) << a).sum();
    let is_usual = |ray: &Ray| ray.direction.iter().chain(&ray.origin).all(|c| c.is_finite() && *c != 0.0);
    let mut hull = Beam::nothing(backward(rays.first()?));
    for ray in rays {
        if !is_usual(ray) || backward(ray) != hull.backward {
            return None;
        }
        for (bounds, of) in [(&mut hull.origins, ray.origin), (&mut hull.speeds, ray.direction.map(f32::abs))]
        {
            for a in 0..3 {
                bounds[0][a] = bounds[0][a].min(of[a].into());
                bounds[1][a] = bounds[1][a].max(of[a].into());
            }
        }
        hull.interval = [hull.interval[0].min(ray.t_min.into()), hull.interval[1].max(ray.t_max.into())];
    }
    Some(hull)
}
