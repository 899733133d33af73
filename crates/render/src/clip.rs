//! What is cut away.

use glam::DVec3;

/// The points with `normal · p ≥ offset`, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Towards what is kept; of any length but zero.
    pub normal: DVec3,
    /// Of the plane: `normal · p` of its points.
    pub offset: f64,
}

/// What is kept of a scene: the points that all of some planes keep.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clip(pub Vec<Plane>);

/// The part of a line that is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Kept {
    /// Parameters; infinite where no plane ends it.
    pub(crate) begin: f64,
    pub(crate) end: f64,
    /// The planes at its ends.
    pub(crate) enters: Option<usize>,
    pub(crate) leaves: Option<usize>,
}

impl Clip {
    /// Adds a box along the world's axes: what is between its corners is kept.
    pub fn add_box(&mut self, low: DVec3, high: DVec3) {
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            self.0.push(Plane { normal: axis, offset: axis.dot(low) });
            self.0.push(Plane { normal: -axis, offset: -axis.dot(high) });
        }
    }

    /// The part of a line; `None` if nothing is kept of it.
    pub(crate) fn kept(&self, origin: DVec3, direction: DVec3) -> Option<Kept> {
        let mut kept = Kept { begin: f64::NEG_INFINITY, end: f64::INFINITY, enters: None, leaves: None };
        for (n, plane) in self.0.iter().enumerate() {
            let distance = plane.offset - plane.normal.dot(origin);
            let speed = plane.normal.dot(direction);
            if speed == 0.0 {
                if distance > 0.0 {
                    return None;
                }
                continue;
            }
            let t = distance / speed;
            if speed > 0.0 && t > kept.begin {
                (kept.begin, kept.enters) = (t, Some(n));
            } else if speed < 0.0 && t < kept.end {
                (kept.end, kept.leaves) = (t, Some(n));
            }
        }
        (kept.begin < kept.end).then_some(kept)
    }

    /// Whether it keeps a point.
    pub fn keeps(&self, p: DVec3) -> bool {
        self.0.iter().all(|plane| plane.normal.dot(p) >= plane.offset)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_through_a_box() {
        let mut clip = Clip::default();
        clip.add_box(DVec3::new(-1.0, -2.0, -3.0), DVec3::new(1.0, 2.0, 3.0));
        assert!(clip.keeps(DVec3::new(1.0, -2.0, 0.0)) && !clip.keeps(DVec3::new(1.1, 0.0, 0.0)));
        let kept = clip.kept(DVec3::new(-5.0, 0.5, 0.0), DVec3::X).unwrap();
        assert_eq!((kept.begin, kept.end, kept.enters, kept.leaves), (4.0, 6.0, Some(0), Some(1)));
        assert_eq!(clip.kept(DVec3::new(-5.0, 2.5, 0.0), DVec3::X), None);
        assert_eq!(clip.kept(DVec3::new(-5.0, 0.0, 9.0), DVec3::new(1.0, 0.0, -0.1)), None);
    }

    #[test]
    fn nothing_is_cut_without_planes_and_all_by_two_that_exclude_each_other() {
        let kept = Clip::default().kept(DVec3::ONE, DVec3::Z).unwrap();
        assert_eq!((kept.begin, kept.end), (f64::NEG_INFINITY, f64::INFINITY));
        let plane = |normal, offset| Plane { normal, offset };
        let clip = Clip(vec![plane(DVec3::X, 1.0), plane(-DVec3::X, 1.0)]);
        assert_eq!(clip.kept(DVec3::ZERO, DVec3::X), None);
        assert_eq!(clip.kept(DVec3::ZERO, DVec3::Y), None);
    }
}
