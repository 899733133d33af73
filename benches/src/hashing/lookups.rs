//! Loops over many look-ups, each a function of its own, so that what is around them does not decide how they are compiled. The method is chosen outside.

use isoray_grid::Scalar;
use isoray_octree::OctreeView;
#[cfg(doc)]
use isoray_octree::Path;

use super::queries::{Queries, Step};
use super::{Method, Trail, Tree, sample_of};

/// A sum over the samples found, by which a timed run is known to have found what it should.
pub fn sum<T: Scalar>(samples: impl Iterator<Item = T>) -> u64 {
    samples.fold(0, |sum: u64, sample| sum.wrapping_mul(3).wrapping_add(sample.to_f32().to_bits().into()))
}

/// The samples at points by `method`, from the root down; their [`sum`].
#[inline(never)]
pub fn by<T: Scalar>(tree: &Tree<'_, T>, method: Method, points: &[[u32; 3]]) -> u64 {
    match method {
        Method::TopDown => sum(points.iter().map(|&p| tree.sample(Method::TopDown, p, &mut ()))),
        Method::FriskenPerry => sum(points.iter().map(|&p| tree.sample(Method::FriskenPerry, p, &mut ()))),
        Method::Knoll2006 => sum(points.iter().map(|&p| tree.sample(Method::Knoll2006, p, &mut ()))),
        Method::Jump => sum(points.iter().map(|&p| tree.sample(Method::Jump, p, &mut ()))),
    }
}

/// By [`OctreeView::locate`]; or by what it does, [`OctreeView::descend`], which is inlined.
#[inline(never)]
pub fn located<T: Scalar>(view: &OctreeView<'_, T>, points: &[[u32; 3]], is_inlined: bool) -> u64 {
    match view.root().filter(|_| is_inlined) {
        Some(root) => {
            let level = view.root_level();
            sum(points.iter().map(|&p| sample_of(&view.descend(root, level, p), p)))
        }
        None => sum(points.iter().map(|&p| sample_of(&view.locate(p), p))),
    }
}

/// The samples at the ends of steps by `method`, from where they start.
#[inline(never)]
pub fn stepped<T: Scalar>(tree: &Tree<'_, T>, method: Method, queries: &Queries<'_, T>) -> u64 {
    match method {
        Method::TopDown => queries.step(|t, ends| tree.neighbor(Method::TopDown, t, ends, &mut ())),
        Method::FriskenPerry => queries.step(|t, ends| tree.neighbor(Method::FriskenPerry, t, ends, &mut ())),
        Method::Knoll2006 => queries.step(|t, ends| tree.neighbor(Method::Knoll2006, t, ends, &mut ())),
        Method::Jump => queries.step(|t, ends| tree.neighbor(Method::Jump, t, ends, &mut ())),
    }
}

/// The same by [`Path::neighbor`].
#[inline(never)]
pub fn neighbors<'a, T: Scalar>(view: &OctreeView<'a, T>, queries: &Queries<'a, T>) -> u64 {
    sum(queries.steps.iter().map(|&Step { trail, from, to }| {
        sample_of(&queries.paths[trail as usize].neighbor(view, from, to), to)
    }))
}

impl<T: Scalar> Queries<'_, T> {
    /// Looks up every neighbour, given the way to where the step starts, and its ends.
    #[inline(always)]
    fn step(&self, neighbor: impl Fn(&Trail<T>, [[u32; 3]; 2]) -> T) -> u64 {
        sum(self.steps.iter().map(|step| neighbor(&self.trails[step.trail as usize], [step.from, step.to])))
    }
}
