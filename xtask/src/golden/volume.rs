//! Volume rendering with a bounded error against the oracle: every pixel.

use anyhow::Result;
use isoray_grid::Scalar;
use isoray_preint::Bounded;
use isoray_render::render_volume;

use super::compared::{colors_picture, over_background};
use super::reference::show;
use super::scenes::EPSILON;
use super::selection::Selection;
use crate::catalog::{Dense, DenseVisitor, Entry, Place};
use crate::shells::{Errors, Subject};

/// Bounds that are tried.
const EPSILONS: [f64; 3] = [1.0 / 64.0, EPSILON, 1e-5];

/// Titles of the columns.
pub(crate) const HEADER: &str =
    "volume rendering                                            ε  max error  rms error  pixels over ε";

/// All views of one volume as shells, shaded and not.
pub(crate) struct Volumes<'a> {
    pub(crate) entry: &'a Entry,
    pub(crate) selection: &'a Selection,
    pub(crate) size: u32,
}

impl DenseVisitor for Volumes<'_> {
    type Output = Result<Vec<String>>;

    fn visit<T: Scalar + Into<f64>>(self, dense: &Dense<T>) -> Result<Vec<String>> {
        let mut failures = Vec::new();
        for place in Place::ALL {
            for is_shaded in [false, true] {
                let shaded = if is_shaded { ", shaded" } else { "" };
                let name = format!("{}, {}{shaded}", self.entry.name, place.name());
                if !self.selection.wants(&name) {
                    continue;
                }
                let subject = Subject::new(self.entry, dense, is_shaded, place, self.size)?;
                let reference = subject.reference(dense)?;
                for epsilon in EPSILONS {
                    let scheme = Bounded::new(&subject.transfer, epsilon, subject.brightest);
                    let scene = subject.scene(&scheme);
                    let image = render_volume(
                        &subject.view(),
                        subject.index_to_world,
                        &subject.camera,
                        &scene,
                        |_, _| {},
                    );
                    let Errors { max, rms, over, worst } = Errors::of(&image, &reference, Some(epsilon));
                    println!("{name:<52} {epsilon:>9.2e} {max:>10.2e} {rms:>10.2e} {over:>14}");
                    if over > 0 {
                        let at = [worst as u32 % self.size, worst as u32 / self.size];
                        let expected = colors_picture(image.size(), |n| reference[n].map(|c| c as f32));
                        let scene = format!("{name}, {epsilon:.2e}, oracle");
                        let shown = show(&scene, &expected, &over_background(&image))?;
                        failures.push(format!(
                            "{name}: {over} pixels are off by more than {epsilon:e}, the worst, {at:?}, by {max:e}; shown in {}",
                            shown.display()
                        ));
                    }
                }
            }
        }
        Ok(failures)
    }
}
