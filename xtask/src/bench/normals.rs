//! Normals: time against error, of the surface that is drawn and of the field that was sampled.

use std::hint::black_box;

use anyhow::{Result, ensure};
use glam::{DAffine3, DVec3};
use isoray_benches::views::View;
use isoray_grid::{Dims, Scalar};
use isoray_oracle::{DenseLattice, Field, Gyroid, MarschnerLobb, Sphere, central_gradient, judge};
use isoray_trace::{Hit, Trace, Tracer};
use serde::Serialize;

use super::timer::{interleave, quantile};
use crate::catalog::{Dense, DenseVisitor, Entry};
use crate::for_oracle::{self, DEGREES_99};

/// Titles of the columns.
const HEADER: &str = "\nNormals at the first hits of a far view, one thread: ns each; angle, in degrees, to the gradient of the surface that is drawn, and of the field that was sampled where that is known.
volume                      normals                    ns | surface: mean      99 % | field: mean      99 %";

/// One kind of normals on one surface.
#[derive(Debug, Serialize)]
pub(crate) struct NormalRow {
    volume: String,
    isovalue: f32,
    normals: &'static str,
    is_default: bool,
    hits: usize,
    ns_per_hit: f64,
    /// Of angles to the gradient of the trilinear interpolant, in degrees.
    surface_mean: f64,
    surface_99: f64,
    /// Of angles to that of the field of which the samples were taken; `None` where nobody knows it.
    field_mean: Option<f64>,
    field_99: Option<f64>,
}

pub(crate) fn run(is_quick: bool, entries: &[Entry], repeat: usize) -> Result<Vec<NormalRow>> {
    println!("{HEADER}");
    let size = if is_quick { 64 } else { 256 };
    let mut rows = Vec::new();
    for entry in entries.iter().filter(|entry| entry.is_real()) {
        let name = &entry.name;
        let normals = Normals { name, isovalue: entry.isovalues[0], field: None, size, repeat };
        rows.extend(entry.visit(normals)??);
    }
    let n = if is_quick { 64 } else { 128 };
    let centre = [f64::from(n - 1) / 2.0; 3];
    let (sphere, gyroid) = (Sphere { centre }, Gyroid { period: f64::from(n) / 4.0 });
    let rings = MarschnerLobb { n };
    let made: [(&str, f32, &dyn Field); 3] = [
        ("sphere", (0.4 * f64::from(n)) as f32, &sphere),
        ("gyroid", 0.1, &gyroid),
        ("Marschner-Lobb", 127.5, &rings),
    ];
    for (name, isovalue, field) in made {
        let name = &format!("{name} {n}, f32");
        let normals = Normals { name, isovalue, field: Some(field), size, repeat };
        rows.extend(normals.visit(&sampled(n, field, |value| value as f32)?)?);
    }
    let name = &format!("Marschner-Lobb {n}, u8");
    let normals = Normals { name, isovalue: 127.5, field: Some(&rings), size, repeat };
    rows.extend(normals.visit(&sampled(n, &rings, |value| value.round() as u8)?)?);
    Ok(rows)
}

/// `n³` samples of a field.
fn sampled<T: Scalar + Into<f64>>(
    n: u32,
    field: &dyn Field,
    quantise: impl Fn(f64) -> T,
) -> Result<Dense<T>> {
    let value = |[x, y, z]: [u32; 3]| quantise(field.value([x, y, z].map(f64::from)));
    let samples = DenseLattice::from_fn([n; 3], value).samples().to_vec();
    Ok(Dense { dims: Dims::new([n; 3])?, samples, index_to_world: DAffine3::IDENTITY })
}

struct Normals<'a> {
    name: &'a str,
    isovalue: f32,
    field: Option<&'a dyn Field>,
    size: u32,
    repeat: usize,
}

/// A hit, and what its normal should be.
struct Known {
    hit: Hit,
    surface: [f64; 3],
    /// The oracle's own central differences.
    central: [f64; 3],
    field: Option<[f64; 3]>,
}

impl DenseVisitor for Normals<'_> {
    type Output = Result<Vec<NormalRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let view = octree.view();
        let known = self.hits(volume, &mut Tracer::new(&view))?;
        let hits: Vec<Hit> = known.iter().map(|known| known.hit).collect();
        let mut tracer = Tracer::new(&view);
        let found: [Vec<[f32; 3]>; 3] = [
            hits.iter().map(Hit::gradient).collect(),
            hits.iter().map(|hit| tracer.central_gradient(hit)).collect(),
            hits.iter().map(|hit| isoray_trace::central_gradient(&view, hit)).collect(),
        ];
        ensure!(found[1] == found[2], "{}: central normals differ if cells are kept", self.name);
        let off = |found: &[[f32; 3]], truth: fn(&Known) -> [f64; 3]| {
            quantile(angles(found, known.iter().map(truth)), 0.99)
        };
        for (found, truth) in
            [(&found[0], (|k| k.surface) as fn(&Known) -> [f64; 3]), (&found[1], |k| k.central)]
        {
            let off = off(found, truth);
            ensure!(off <= DEGREES_99, "{}: normals are {off} degrees off", self.name);
        }
        let seconds = interleave(
            self.repeat,
            &mut [
                &mut || each(&hits, Hit::gradient),
                &mut || each(&hits, |hit| tracer.central_gradient(hit)),
                &mut || each(&hits, |hit| isoray_trace::central_gradient(&view, hit)),
            ],
        );
        let names = ["forward", "central", "central, cells not kept"];
        let rows = names.into_iter().zip(&found).zip(seconds);
        Ok(rows.map(|((normals, found), seconds)| self.row(normals, &known, found, seconds)).collect())
    }
}

impl Normals<'_> {
    /// Those on which the oracle's answer does not hang on rounding.
    fn hits<T: Scalar + Into<f64>>(&self, volume: &Dense<T>, tracer: &mut impl Trace) -> Result<Vec<Known>> {
        let lattice = for_oracle::lattice(volume);
        let view = View::far(volume.dims, self.size, self.size);
        let mut known = Vec::new();
        for &direction in &view.directions {
            let ray = view.ray(direction);
            let verdict = judge(&lattice, &for_oracle::ray(&ray), self.isovalue);
            if verdict.grazing {
                continue;
            }
            let found = tracer.first_hit(&ray, self.isovalue);
            ensure!(found.is_some() == verdict.hit.is_some(), "{}: a hit is false or missed", self.name);
            if let (Some(hit), Some(truth)) = (found, verdict.hit) {
                known.push(Known {
                    hit,
                    surface: truth.gradient,
                    central: central_gradient(&lattice, truth.position, truth.cell),
                    field: self.field.map(|field| field.gradient(truth.position)),
                });
            }
        }
        ensure!(!known.is_empty(), "{}: nothing is hit", self.name);
        Ok(known)
    }

    fn row(&self, normals: &'static str, known: &[Known], found: &[[f32; 3]], seconds: f64) -> NormalRow {
        let surface = angles(found, known.iter().map(|known| known.surface));
        let field: Option<Vec<_>> = known.iter().map(|known| known.field).collect();
        let field = field.map(|truth| angles(found, truth.into_iter()));
        let mean = |angles: &[f64]| angles.iter().sum::<f64>() / angles.len() as f64;
        let row = NormalRow {
            volume: self.name.to_owned(),
            isovalue: self.isovalue,
            normals,
            is_default: normals == "forward",
            hits: found.len(),
            ns_per_hit: seconds * 1e9 / found.len() as f64,
            surface_mean: mean(&surface),
            surface_99: quantile(surface, 0.99),
            field_mean: field.as_deref().map(mean),
            field_99: field.map(|angles| quantile(angles, 0.99)),
        };
        let of_field = |value: Option<f64>| value.map_or("-".to_owned(), |degrees| format!("{degrees:.4}"));
        println!(
            "{:<27} {normals:<24} {:>5.1} | {:>13.2e} {:>9.2e} | {:>11} {:>9}",
            row.volume,
            row.ns_per_hit,
            row.surface_mean,
            row.surface_99,
            of_field(row.field_mean),
            of_field(row.field_99)
        );
        row
    }
}

#[inline(never)]
fn each(hits: &[Hit], mut gradient: impl FnMut(&Hit) -> [f32; 3]) {
    for hit in hits {
        black_box(gradient(black_box(hit)));
    }
}

/// Angles between gradients, in degrees; where one is zero there is none.
fn angles(found: &[[f32; 3]], truth: impl Iterator<Item = [f64; 3]>) -> Vec<f64> {
    let unit = |v: [f64; 3]| DVec3::from_array(v).try_normalize();
    let pairs = found.iter().zip(truth);
    let angle =
        |(found, truth): (&[f32; 3], _)| Some(for_oracle::degrees(unit(found.map(f64::from))?, unit(truth)?));
    pairs.filter_map(angle).collect()
}
