//! What levels of detail have to keep to.

use anyhow::{Result, ensure};
use glam::DVec3;
use isoray_octree::Coarse;

use super::{LEVELS, LodRow, LodView, Subject, name};

/// The share of the paper's error that the default may have.
const BAR: f64 = 0.1;
/// Of a view's rays this share at least hit the volume itself, lest the rest mean nothing: the least there is, a plane seen by 7°, has 5 % of them.
const SEEN: f64 = 0.01;
/// Up to this level half of the hits or more have a counterpart in whatever volume; level 4 of short runs has but four cells along an axis.
const FOUND: u32 = 3;
/// Of the rays that hit a plane, those that may do so in one volume only, in %, besides one ray: they pass its outline within the rounding of depths, 4·10⁻³ voxels at most. Where the
/// least of it is seen, in short runs, that is 2 square voxels along 250 voxels of outline, of 600 square voxels.
const OUTLINE: f64 = 0.3;

/// What the default and the filter are to keep to: no error of linear data, and a tenth of the paper's bias of others.
///
/// Of others only those that are smooth on the lattices compared do, down to the levels that the subject states. The filter's bias is twice that of injection, and so it does a level
/// less: at level 4 of the sphere of 513³ it has up to 0.18 of the paper's, and 0.14 of Marschner-Lobb. On the heptane fire, and in short runs on the tooth, sheets are as thin as coarse voxels, and
/// come and go with whatever samples: there two thirds of the paper's bias stay in one direction or another at level 1, and more farther up, or where the paper's own cancels out. That is printed.
pub(super) fn judge(subject: &Subject<'_>, rows: &[LodRow]) -> Result<()> {
    let of = |kind: Coarse, level| rows.iter().find(|row| row.level == level && row.kind == kind.name());
    for level in LEVELS {
        let Some(paper) = of(Coarse::Mean, level) else { continue };
        for (kind, behind) in [(Coarse::default(), 0), (Coarse::Filtered, 1)] {
            let Some(row) = of(kind, level) else { continue };
            let kept = subject.kept.map(|to| level + behind <= to);
            row.views.iter().try_for_each(|view| seen(subject, row, view, kept[0]))?;
            match subject.slope {
                Some(slope) => row.views.iter().try_for_each(|view| linear(subject, row, view, slope))?,
                None => biased(row, paper, kept)?,
            }
        }
    }
    Ok(())
}

/// There is a surface, and the coarse one is seen too.
fn seen(subject: &Subject<'_>, row: &LodRow, view: &LodView, is_kept: bool) -> Result<()> {
    let LodRow { volume, kind, level, .. } = row;
    let of = format!("{volume}: {kind}, level {level}, {}", name(view.direction));
    let least = SEEN * f64::from(subject.rays).powi(2);
    let LodView { hits, common, .. } = view;
    ensure!(*hits as f64 >= least, "{of}: expected hits of at least {least} rays, found {hits}");
    let is_exempt = !is_kept && *level > FOUND;
    let is_half = 2 * common >= *hits;
    ensure!(
        is_exempt || is_half,
        "{of}: expected at least half of {hits} hits in the coarse volume too, found {common}"
    );
    Ok(())
}

/// A plane is where it was.
fn linear(subject: &Subject<'_>, row: &LodRow, view: &LodView, slope: [f64; 3]) -> Result<()> {
    let bound = rounding(subject, slope, view.direction, row.level);
    let LodRow { volume, kind, level, .. } = row;
    let of = format!("{volume}: {kind}, level {level}, {}", name(view.direction));
    let LodView { mean, rms, one_only, hits, .. } = view;
    ensure!(*rms <= bound, "{of}: off by {mean} voxels, where rounding is at most {bound}");
    let most = OUTLINE + 100.0 / *hits as f64;
    ensure!(*one_only <= most, "{of}: expected at most {most} % that hit in one only, found {one_only} %");
    Ok(())
}

/// Prints what is left of the paper's bias, and holds it against the bar where it is to be kept: in each direction, and in that where it is largest.
fn biased(row: &LodRow, paper: &LodRow, kept: [bool; 2]) -> Result<()> {
    let pairs = row.views.iter().zip(&paper.views);
    let share = |(view, paper): (&LodView, &LodView)| (view.mean / paper.mean).abs();
    let misses: Vec<_> = pairs
        .clone()
        // One that is no number is none that keeps to it.
        .filter(|&pair| share(pair).is_nan() || share(pair) > BAR)
        .map(|pair| format!("{} {:.3}", name(pair.0.direction), share(pair)))
        .collect();
    let largest = row.worst(|v| v.mean) / paper.worst(|v| v.mean);
    let LodRow { volume, kind, level, .. } = row;
    println!(
        "{volume:<22} {kind:<9} {level:>5}: {largest:.4} of the paper's placement, largest of all directions; each at most {:.3}{}",
        pairs.map(share).fold(0.0, f64::max),
        if misses.is_empty() { String::new() } else { format!("; over {BAR}: {}", misses.join(", ")) }
    );
    ensure!(
        !kept[0] || misses.is_empty(),
        "{volume}: {kind}, level {level}: expected {BAR} of the paper's bias or less each way, found {}",
        misses.join(", ")
    );
    ensure!(
        !kept[1] || largest <= BAR,
        "{volume}: {kind}, level {level}: expected at most {BAR} of the paper's largest bias, found {largest}"
    );
    Ok(())
}

/// What rounding alone can do to a depth in a linear volume, in voxels: to `t` itself, a few units in its last place, and to values, one at each level and one
/// more in the cell, each moving the surface by that over the slope along the ray.
fn rounding(subject: &Subject<'_>, slope: [f64; 3], direction: [i32; 3], level: u32) -> f64 {
    let along = DVec3::from_array(direction.map(f64::from)).normalize().dot(DVec3::from_array(slope)).abs();
    let value = 2.0 * f64::from(subject.isovalue.abs());
    // Twice the diagonal of 129³, at most.
    let depth = 450.0;
    f64::from(f32::EPSILON) * (4.0 * depth + f64::from(level + 2) * value / along)
}
