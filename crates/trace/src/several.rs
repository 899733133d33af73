//! Crossings of several isosurfaces, in order, and of rays that start on one.

use std::ops::ControlFlow;

use isoray_cell::root::{Crossing as CellCrossing, crossings};
use isoray_cell::{Cubic, Segment, relative};

use crate::content::Beyond;
use crate::hit::{Candidate, Hit};
use crate::jump::jumps;
use crate::ray::DepartingRay;

/// A crossing of one of several isosurfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Which: an index into the isovalues that were asked for.
    pub surface: usize,
    /// Where.
    pub hit: Hit,
}

/// That a ray starts on a surface.
#[derive(Clone, Copy, Debug)]
pub struct Departure {
    surface: usize,
    into_inside: bool,
}

impl From<&DepartingRay> for Departure {
    fn from(&DepartingRay { surface, into_inside, .. }: &DepartingRay) -> Self {
        Self { surface, into_inside }
    }
}

/// A cell on a ray's way.
pub struct CellOnWay<'c> {
    /// Its low corner.
    pub cell: [u32; 3],
    /// At its corners, x fastest.
    pub samples: &'c [f32; 8],
    /// The ray's stretch, cell-local.
    pub segment: &'c Segment,
    /// Where that begins and ends.
    pub interval: [f64; 2],
    /// What the ray sees just before and just behind it, where other arithmetic goes there.
    pub beyond: &'c [Option<Beyond>; 2],
}

/// Finds crossings cell by cell.
pub struct Crossings<'f> {
    /// Of which surfaces.
    pub isovalues: &'f [f32],
    /// Until it has been met.
    pub departure: Option<Departure>,
    /// Where the ray begins.
    pub t_min: f64,
    /// Room for those of one cell.
    pub found: &'f mut Vec<CellCrossing>,
}

impl Crossings<'_> {
    /// Calls `visit` for all crossings in the next cell, in order.
    pub fn cell(
        &mut self,
        on_way: &CellOnWay<'_>,
        visit: &mut impl FnMut(&Crossing) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        crossings(on_way.samples, self.isovalues, on_way.segment, self.found);
        // Only the first cell begins where the ray does.
        if let Some(departure) = self.departure.take_if(|_| on_way.interval[0] <= self.t_min) {
            depart(departure, self.isovalues, on_way, self.found);
        }
        if !matches!(on_way.beyond, [None, None]) {
            self.take_jumps(on_way);
        }
        let [begin, end] = on_way.interval;
        self.found.iter().try_for_each(|&CellCrossing { s, surface, is_entering }| {
            let corners = relative(on_way.samples, self.isovalues[surface]);
            let t = (begin + f64::from(s) * (end - begin)) as f32;
            let local = on_way.segment.at(s);
            visit(&Crossing {
                surface,
                hit: Hit { t, level: 0, cell: on_way.cell, local, corners, is_entering },
            })
        })
    }
}

impl Crossings<'_> {
    /// Adds the crossings at the ends of the stretch.
    #[cold]
    fn take_jumps(&mut self, on_way: &CellOnWay<'_>) {
        for (surface, &isovalue) in self.isovalues.iter().enumerate() {
            let candidate = Candidate {
                level: 0,
                cell: on_way.cell,
                corners: relative(on_way.samples, isovalue),
                segment: *on_way.segment,
                interval: on_way.interval,
            };
            let at_ends = jumps(&candidate, on_way.beyond, isovalue).into_iter().zip([0.0, 1.0]);
            for (hit, s) in at_ends.filter_map(|(hit, s)| Some((hit?, s))) {
                let crossing = CellCrossing { s, surface, is_entering: hit.is_entering };
                let at = if s == 0.0 { 0 } else { self.found.len() };
                self.found.insert(at, crossing);
            }
        }
        self.found.sort_by(|a, b| a.s.total_cmp(&b.s));
    }
}

/// Replaces the crossings of the departed surface in the ray's first cell.
fn depart(departure: Departure, isovalues: &[f32], on_way: &CellOnWay<'_>, found: &mut Vec<CellCrossing>) {
    let Departure { surface, into_inside } = departure;
    let Some(&isovalue) = isovalues.get(surface) else { return };
    let departing = Cubic::along(&relative(on_way.samples, isovalue), on_way.segment).departing();
    let mut is_inside = departing.leaves_inside();
    found.retain(|crossing| crossing.surface != surface);
    if is_inside != into_inside {
        found.push(CellCrossing { s: 0.0, surface, is_entering: is_inside });
    }
    for &s in departing.crossings().iter() {
        is_inside = !is_inside;
        found.push(CellCrossing { s, surface, is_entering: is_inside });
    }
    // Stable: what was in order stays so.
    found.sort_by(|a, b| a.s.total_cmp(&b.s));
}
