//! Rays that share lanes on their way through a volume, and what each gathers.

use isoray_preint::{Integrate, Lighting, Radiance, Segments};

use crate::brick::Brick;
use crate::offset::mirror;
use crate::ray::ClippedRay;
use crate::ray_lanes::{Ends, GROUP, InBlock, Lanes, RayLanes, Stretches, met};
use crate::volume_packet::bits;
use crate::work::Counters;

/// What all rays have in common.
pub(crate) struct Integral<'s, I> {
    pub(crate) world_per_t: f64,
    pub(crate) scheme: &'s I,
}

/// A few rays.
#[derive(Clone, Debug)]
pub(crate) struct RayGroup {
    rays: [Option<ClippedRay>; GROUP],
    /// Those that run to the sides that are looked at.
    lanes: RayLanes,
    backward: u32,
    gathered: [Gathered; GROUP],
}

/// What is gathered along one ray.
#[derive(Clone, Debug, Default)]
struct Gathered {
    segments: Segments,
    lighting: Option<Lighting>,
    radiance: Radiance,
}

impl Default for RayGroup {
    fn default() -> Self {
        let rays = [None; GROUP];
        Self { rays, lanes: RayLanes::new(&rays, 0), backward: 0, gathered: Default::default() }
    }
}

impl RayGroup {
    /// Takes other rays, with what each is lit by.
    pub(crate) fn take(&mut self, ray: impl Fn(usize) -> Option<(ClippedRay, Option<Lighting>)>) {
        for (lane, gathered) in self.gathered.iter_mut().enumerate() {
            let (ray, lighting) = ray(lane).unzip();
            self.rays[lane] = ray;
            gathered.lighting = lighting.flatten();
            gathered.radiance = Radiance::default();
            gathered.segments.clear();
        }
    }

    /// The ways that the rays face, a bit each.
    pub(crate) fn facings(&self) -> u32 {
        self.rays.iter().flatten().fold(0, |facings, ray| facings | 1 << ray.backward)
    }

    /// Looks at the rays that run to these sides.
    pub(crate) fn turn_to(&mut self, backward: u32) {
        self.backward = backward;
        self.lanes = RayLanes::new(&self.rays, backward);
    }

    #[inline(always)]
    pub(crate) fn lanes(&self) -> &RayLanes {
        &self.lanes
    }

    /// Passes through a cube in which the field is constant.
    pub(crate) fn constant<I: Integrate>(
        &mut self,
        value: f32,
        corner: [u32; 3],
        edge: u32,
        integral: &Integral<'_, I>,
    ) {
        let stretches = self.lanes.stretches(corner, edge);
        let length = lengths(stretches, integral);
        for lane in bits(met(stretches)) {
            self.gathered[lane].segments.push_constant(value, length[lane]);
            if self.gathered[lane].is_done(integral) {
                self.lanes.end(lane);
            }
        }
    }

    /// Passes through the visible cells of a block, in an order that suits all rays: each meets its own in the order in which it would alone.
    #[inline(never)]
    pub(crate) fn block<I: Integrate>(
        &mut self,
        brick: &Brick,
        corner: [u32; 3],
        integral: &Integral<'_, I>,
        counters: &mut impl Counters,
    ) {
        let in_block = InBlock::new(&self.lanes, corner);
        let all = in_block.all();
        let mut going = met(all);
        if going == 0 {
            return;
        }
        let mut ended = 0;
        let mirror = mirror(self.backward);
        for k in 0..4 {
            let layer = in_block.layer(all, 2, k);
            for j in 0..4 {
                let row = (j << 2 | k << 4) ^ mirror;
                let shown = brick.shown() >> (row & !3) & 0xf;
                let in_row = in_block.layer(layer, 1, j);
                if shown == 0 || met(in_row) & going == 0 {
                    continue;
                }
                for i in 0..4 {
                    let offset = row ^ i;
                    let stretches = in_block.layer(in_row, 0, i);
                    let here = met(stretches) & going;
                    if shown >> (offset & 3) & 1 == 0 || here == 0 {
                        continue;
                    }
                    let ends = in_block.ends(corner, offset, [i, j, k], stretches);
                    let done =
                        push(&mut self.gathered, here, &brick.corners(offset), &ends, stretches, integral);
                    (0..here.count_ones()).for_each(|_| counters.cell());
                    going &= !done;
                    ended |= done;
                }
            }
        }
        bits(ended).for_each(|lane| self.lanes.end(lane));
    }

    /// Integrates what is left, of rays that have not ended early; what the ray in this lane has gathered by the end of its way.
    pub(crate) fn finish<I: Integrate>(&mut self, lane: usize, integral: &Integral<'_, I>) -> Radiance {
        let one = &mut self.gathered[lane];
        if one.segments.count() > 0 {
            one.flush(integral);
        }
        one.radiance
    }
}

/// Adds the stretches of some lanes in a cell; those that end there.
#[inline(always)]
fn push<I: Integrate>(
    gathered: &mut [Gathered; GROUP],
    lanes: u32,
    corners: &[f32; 8],
    [entry, exit]: &Ends,
    stretches: Stretches,
    integral: &Integral<'_, I>,
) -> u32 {
    let length = lengths(stretches, integral);
    let mut done = 0;
    for lane in bits(lanes) {
        let at = |ends: &[[f32; GROUP]; 3]| ends.map(|along| along[lane]);
        let one = &mut gathered[lane];
        one.segments.push(corners, at(entry), at(exit), length[lane]);
        done |= u32::from(one.is_done(integral)) << lane;
    }
    done
}

/// In the world.
#[inline(always)]
fn lengths<I>([begin, end]: Stretches, integral: &Integral<'_, I>) -> [f32; GROUP] {
    ((end - begin) * Lanes::splat(integral.world_per_t)).to_array().map(|length| length as f32)
}

impl Gathered {
    /// Integrates what has been gathered if there is no room for more; whether what is left cannot matter.
    #[inline(always)]
    fn is_done<I: Integrate>(&mut self, integral: &Integral<'_, I>) -> bool {
        if !self.segments.is_full() {
            return false;
        }
        self.flush(integral);
        self.radiance.is_done
    }

    #[inline(never)]
    fn flush<I: Integrate>(&mut self, integral: &Integral<'_, I>) {
        integral.scheme.integrate(&self.segments, self.lighting.as_ref(), &mut self.radiance);
        self.segments.clear();
    }
}
