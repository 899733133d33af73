//! Table 4, Figures 11 to 13, 15 and 16, and what the text says of them: whole frames, with levels of detail, smooth normals and shadows.

use anyhow::{Context, Result, ensure};
use isoray_grid::Scalar;
use isoray_render::{Camera, Light, Normals, Scene, Traversal};

use crate::bench::papers::{Figure, PaperRow, Setting, print, print_titles};
use crate::bench::picture::{LAMP, Pictures};
use crate::bench::timer::interleave_kept;
use crate::catalog::{Dense, DenseVisitor, Entry, Place};

/// Ways to make a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Way {
    traversal: Traversal,
    /// Of levels of detail; zero: exact.
    ratio: f64,
    normals: Normals,
    /// Not a headlight, in which nothing has a shadow that can be seen.
    has_lamp: bool,
    shadows: bool,
}

const SINGLE: Way = Way {
    traversal: Traversal::Single,
    ratio: 0.0,
    normals: Normals::Forward,
    has_lamp: false,
    shadows: false,
};
const PACKETS: Way = Way { traversal: Traversal::Masked, ..SINGLE };
const LOD_1: Way = Way { ratio: 1.0, ..PACKETS };
const LOD_2: Way = Way { ratio: 2.0, ..PACKETS };
const LOD_4: Way = Way { ratio: 4.0, ..PACKETS };
const AUTO_LOD_1: Way = Way { traversal: Traversal::Auto, ..LOD_1 };
const SINGLE_CENTRAL: Way = Way { normals: Normals::Central, ..SINGLE };
const CENTRAL: Way = Way { normals: Normals::Central, ..PACKETS };
const CENTRAL_LOD_1: Way = Way { normals: Normals::Central, ..LOD_1 };
const LIT: Way = Way { has_lamp: true, ..CENTRAL };
const SHADOWS: Way = Way { shadows: true, ..LIT };
const WAYS: [Way; 11] =
    [SINGLE, PACKETS, LOD_1, AUTO_LOD_1, LOD_2, LOD_4, SINGLE_CENTRAL, CENTRAL, CENTRAL_LOD_1, LIT, SHADOWS];

impl Way {
    fn scene(&self, isovalue: f32) -> Scene<'static> {
        let light = if self.has_lamp { Light::Direction(LAMP) } else { Light::Headlight };
        Scene {
            normals: self.normals,
            lights: vec![light],
            shadows: self.shadows,
            traversal: self.traversal,
            ..Scene::of(isovalue)
        }
    }
}

/// Table 4: frames a second of single rays without, of packets of 8x8 with levels of detail; by time step, far and close.
struct Step {
    scene: &'static str,
    isovalue: f32,
    /// Of step 270, the last.
    time: f64,
    rates: [[[f64; 2]; 3]; 2],
}

const STEPS: [Step; 3] = [
    Step {
        scene: "RM 50",
        isovalue: 20.0,
        time: 50.0 / 270.0,
        rates: [[[2.5, 3.5], [14.5, 19.5], [4.5, 6.5]], [[2.0, 6.9], [12.1, 39.8], [3.6, 14.2]]],
    },
    Step {
        scene: "RM 150",
        isovalue: 20.0,
        time: 150.0 / 270.0,
        rates: [[[1.9, 2.5], [11.1, 15.0], [3.4, 4.9]], [[1.7, 8.1], [12.0, 44.2], [3.5, 14.6]]],
    },
    Step {
        scene: "RM 270",
        isovalue: 160.0,
        time: 1.0,
        rates: [[[1.1, 1.1], [7.2, 12.4], [2.2, 2.2]], [[0.2, 4.7], [1.4, 38.6], [0.4, 9.2]]],
    },
];
/// Columns of the table: on what, how many cores, and which of the two sizes.
const COLUMNS: [(&str, f64, usize); 3] = [
    ("Core Duo, 2 cores, 512x512", 2.0, 0),
    ("Xeon, 8 cores, 512x512", 8.0, 0),
    ("Xeon, 8 cores, 1024x1024", 8.0, 1),
];
const EDGES: [f64; 2] = [512.0, 1024.0];
const PLACES: [Place; 2] = [Place::Far, Place::Close];

/// How many times as long one picture takes as another; each a way, and which of the two sizes it has.
struct Claim {
    place: &'static str,
    what: &'static str,
    hardware: &'static str,
    scene: &'static str,
    paper: f64,
    slow: (Way, usize),
    fast: (Way, usize),
}

const fn claim(
    [place, scene, what]: [&'static str; 3],
    hardware: &'static str,
    paper: f64,
    slow: (Way, usize),
    fast: (Way, usize),
) -> Claim {
    Claim { place, what, hardware, scene, paper, slow, fast }
}

const DUO: &str = "Core Duo 2.16 GHz";
const XEON: &str = "8 cores of Xeon 3 GHz";

#[rustfmt::skip]
const CLAIMS: [Claim; 12] = [
    claim(["2009, Figure 11", "-", "central : forward normals, 8x8"], DUO, 5.5 / 4.7, (CENTRAL, 0), (PACKETS, 0)),
    claim(["2009, 7.1", "-", "central : forward normals, single"], DUO, 2.0, (SINGLE_CENTRAL, 0), (SINGLE, 0)),
    claim(["2009, Figure 12", "-", "shadows : none, central, 8x8"], DUO, 5.1 / 3.9, (SHADOWS, 0), (LIT, 0)),
    claim(["2009, Figure 13", "RM 270", "single : 8x8, LOD 1"], DUO, 1.0 / 0.92, (SINGLE, 0), (LOD_1, 0)),
    claim(["2009, Figure 13", "RM 270", "single : 8x8, LOD 2"], DUO, 1.9 / 0.92, (SINGLE, 0), (LOD_2, 0)),
    claim(["2009, Figure 13", "RM 270", "single : 8x8, LOD 4"], DUO, 3.6 / 0.92, (SINGLE, 0), (LOD_4, 0)),
    claim(["2009, 8.3", "-", "1024x1024 : 512x512, single"], DUO, 4.0, (SINGLE, 1), (SINGLE, 0)),
    claim(["2009, 8.3", "-", "1024x1024 : 512x512, 8x8, LOD 1"], DUO, 2.0, (LOD_1, 1), (LOD_1, 0)),
    claim(["2009, Figure 15", "femur", "the same, central, shadows, no LOD"], DUO, 6.0 / 3.1, (SHADOWS, 1), (SHADOWS, 0)),
    claim(["2009, Figure 16", "RM 270", "exact : LOD 1, 8x8, 1024x1024"], XEON, 4.2 / 1.8, (PACKETS, 1), (LOD_1, 1)),
    claim(["2009, Figure 16", "RM 270", "the same with central normals"], XEON, 3.1 / 1.3, (CENTRAL, 1), (CENTRAL_LOD_1, 1)),
    claim(["2009, Figure 16", "RM 270", "central : forward, 8x8, LOD 1"], XEON, 4.2 / 3.1, (CENTRAL_LOD_1, 1), (LOD_1, 1)),
];

/// Measures mixing layers in place of the instability, and for what is said of no scene the heptane fire too.
pub(super) fn run(setting: Setting<'_>) -> Result<Vec<PaperRow>> {
    let edge = if setting.quick { 64 } else { 512 };
    // The second time with rays as many voxels apart as theirs, of whose volume ours have a quarter of the side: coarse levels are there for what that costs.
    let sizes: &[[u32; 2]] = if setting.quick { &[[64, 128]] } else { &[[512, 1024], [128, 256]] };
    let mixing = STEPS.iter().map(|step| (Some(step), Entry::mixing(edge, step.time, step.isovalue), sizes));
    let heptane = setting.heptane().map(|entry| (None, entry, &sizes[..1]));
    let mut measured = Vec::new();
    for (step, entry, sizes) in mixing.chain(heptane).filter(|(_, entry, _)| setting.has(entry)) {
        for &sizes in sizes {
            let measure = Measure { isovalue: entry.isovalues[0], sizes, repeat: setting.repeat };
            let seconds = entry.visit(measure)??;
            measured.push(Measured { step, entry: entry.clone(), sizes, seconds });
        }
    }
    print_titles("theirs on", &["single, frames/s a core", "8x8, LOD 1", "x single"]);
    let mut rows: Vec<PaperRow> = measured.iter().flat_map(Measured::table).collect();
    print_titles("how many times as long", &["far", "close"]);
    rows.extend(CLAIMS.iter().flat_map(|claim| measured.iter().map(|measured| measured.claim(claim))));
    Ok(rows)
}

/// Seconds by place, size and way.
type Seconds = [[[f64; WAYS.len()]; 2]; 2];

struct Measure {
    isovalue: f32,
    sizes: [u32; 2],
    repeat: usize,
}

impl DenseVisitor for Measure {
    type Output = Result<Seconds>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let pictures = Pictures::new(&octree);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().context("no thread")?;
        let mut seconds = [[[f64::NAN; WAYS.len()]; 2]; 2];
        for (place, of_place) in PLACES.into_iter().zip(&mut seconds) {
            for (size, of_size) in self.sizes.into_iter().zip(of_place) {
                let camera = volume.camera(place, size)?;
                *of_size = pool.install(|| self.seconds(&pictures, &camera)).context(place.name())?;
            }
        }
        Ok(seconds)
    }
}

impl Measure {
    fn seconds<T: Scalar>(&self, pictures: &Pictures<'_, T>, camera: &Camera) -> Result<[f64; WAYS.len()]> {
        let picture = |way: &Way| pictures.frame(camera, &way.scene(self.isovalue), way.ratio).0;
        let mut frames = WAYS.map(|way| move || picture(&way));
        let mut variants: Vec<&mut dyn FnMut() -> _> = frames.iter_mut().map(|frame| frame as _).collect();
        let (seconds, timed) = interleave_kept(self.repeat, &mut variants);
        for (way, timed) in WAYS.iter().zip(&timed) {
            let alone = picture(&Way { traversal: Traversal::Single, ..*way });
            ensure!(alone.pixels().iter().any(|pixel| pixel.depth.is_finite()), "no ray hits");
            ensure!(*timed == alone, "{way:?}: not the picture of single rays");
        }
        Ok(std::array::from_fn(|n| seconds[n]))
    }
}

/// A volume, and whether it stands in for a time step.
struct Measured {
    step: Option<&'static Step>,
    entry: Entry,
    sizes: [u32; 2],
    seconds: Seconds,
}

impl Measured {
    fn seconds(&self, place: usize, (way, size): (Way, usize)) -> f64 {
        WAYS.iter().position(|&w| w == way).map_or(f64::NAN, |n| self.seconds[place][size][n])
    }

    /// Rows of Table 4.
    fn table(&self) -> Vec<PaperRow> {
        let Some(step) = self.step else { return Vec::new() };
        let mut rows = Vec::new();
        for place in 0..2 {
            for (column, (hardware, cores, size)) in COLUMNS.into_iter().enumerate() {
                let [single, packets] = step.rates[place][column];
                // Of as many rays as theirs.
                let share = (f64::from(self.sizes[size]) / EDGES[size]).powi(2);
                for (variant, way) in [(hardware, LOD_1), ("  ours: as the tracer chooses", AUTO_LOD_1)] {
                    let [ours, ours_packets] =
                        [SINGLE, way].map(|way| share / self.seconds(place, (way, size)));
                    let figures = vec![
                        Figure { what: "single, frames/s a core", paper: single / cores, ours },
                        Figure {
                            what: "8x8, LOD 1, frames/s a core",
                            paper: packets / cores,
                            ours: ours_packets,
                        },
                        Figure { what: "x single", paper: packets / single, ours: ours_packets / ours },
                    ];
                    let row = PaperRow {
                        hardware,
                        variant: variant.to_owned(),
                        figures,
                        ..self.row("2009, Table 4", step.scene, size)
                    };
                    rows.push(PaperRow { view: PLACES[place].name(), ..row });
                }
            }
        }
        rows.iter().for_each(print);
        rows
    }

    fn claim(&self, claim: &Claim) -> PaperRow {
        let figure = |place: usize| Figure {
            what: PLACES[place].name(),
            paper: claim.paper,
            ours: self.seconds(place, claim.slow) / self.seconds(place, claim.fast),
        };
        let figures = vec![figure(0), figure(1)];
        let row = self.row(claim.place, claim.scene, claim.slow.1);
        let row = PaperRow {
            hardware: claim.hardware,
            variant: claim.what.to_owned(),
            figures,
            view: "both",
            ..row
        };
        print(&row);
        row
    }

    fn row(&self, place: &'static str, scene: &'static str, size: usize) -> PaperRow {
        PaperRow {
            place,
            hardware: "",
            scene,
            volume: self.entry.name.clone(),
            isovalue: self.entry.isovalues[0],
            view: "",
            size: self.sizes[size],
            variant: String::new(),
            figures: Vec::new(),
        }
    }
}
