//! Rays that meet a lattice where comparisons tie.

use super::SplitMix64;
use crate::OracleRay;

/// The kinds of adversarial rays. Targets and origins "inside" lie in the closed domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RayKind {
    /// From outside through a lattice vertex.
    ThroughVertex,
    /// From outside through a point of a cell's edge.
    ThroughEdge,
    /// From outside through a point of a cell's face.
    ThroughFace,
    /// Parallel to an axis, between the lattice planes of the other two.
    AxisParallel,
    /// Along the edges of cells.
    AlongEdges,
    /// In a lattice plane, the border's among them, in any direction.
    InFace,
    /// In one of the six faces of the domain, in any direction.
    InBorderFace,
    /// Through vertex after vertex, diagonally in one plane or in space.
    Diagonal,
    /// From a lattice vertex.
    FromVertex,
    /// From a point in a cell's face.
    FromFace,
    /// From a point inside a cell.
    FromInside,
    /// One or two components of 1e-20, 1e-38, or below the normal range.
    TinyComponents,
    /// Components of -0.0.
    NegativeZero,
    /// From about 1e4 voxels away.
    FarOrigin,
    /// `t_min` and `t_max` inside the domain.
    Clipped,
    /// From anywhere near to anywhere inside.
    Random,
}

impl RayKind {
    /// All kinds, in the order in which seeds cycle through them.
    pub const ALL: [Self; 16] = [
        Self::ThroughVertex,
        Self::ThroughEdge,
        Self::ThroughFace,
        Self::AxisParallel,
        Self::AlongEdges,
        Self::InFace,
        Self::InBorderFace,
        Self::Diagonal,
        Self::FromVertex,
        Self::FromFace,
        Self::FromInside,
        Self::TinyComponents,
        Self::NegativeZero,
        Self::FarOrigin,
        Self::Clipped,
        Self::Random,
    ];

    /// A ray of this kind for a lattice of `dims` samples; it starts at `t = 0` and has no end, but for
    /// [`RayKind::Clipped`].
    pub fn generate(self, dims: [u32; 3], seed: u64) -> OracleRay {
        let mut maker = Maker { rng: SplitMix64::new(seed), dims };
        let m = &mut maker;
        match self {
            Self::ThroughVertex => m.through([Place::Plane; 3]),
            Self::ThroughEdge => m.through_some([Place::Between, Place::Plane, Place::Plane]),
            Self::ThroughFace => m.through_some([Place::Between, Place::Between, Place::Plane]),
            Self::AxisParallel => m.parallel(Place::Between),
            Self::AlongEdges => m.parallel(Place::Plane),
            Self::InFace => m.in_plane(Place::Plane),
            Self::InBorderFace => m.in_plane(Place::Border),
            Self::Diagonal => m.diagonal(),
            Self::FromVertex => m.starting_in([Place::Plane; 3]),
            Self::FromFace => m.starting_in_some([Place::Between, Place::Between, Place::Plane]),
            Self::FromInside => m.starting_in([Place::Between; 3]),
            Self::TinyComponents => m.tiny(),
            Self::NegativeZero => m.negative_zero(),
            Self::FarOrigin => m.far(),
            Self::Clipped => m.clipped(),
            Self::Random => {
                let origin = m.outside();
                let target = m.point([Place::Between; 3]);
                ray(origin, difference(target, origin))
            }
        }
    }
}

/// A ray of the kind that `seed` comes to in the cycle of [`RayKind::ALL`].
pub fn adversarial_ray(dims: [u32; 3], seed: u64) -> OracleRay {
    RayKind::ALL[(seed % RayKind::ALL.len() as u64) as usize].generate(dims, seed)
}

/// Where a coordinate lies between the samples of an axis.
#[derive(Clone, Copy)]
enum Place {
    /// On a lattice plane.
    Plane,
    /// On the first or the last lattice plane.
    Border,
    /// Anywhere, planes excepted but for an accident.
    Between,
}

fn ray(origin: [f32; 3], direction: [f32; 3]) -> OracleRay {
    OracleRay { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
}

fn difference(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

fn normalised(d: [f32; 3]) -> [f32; 3] {
    let length = d.iter().map(|&c| f64::from(c).powi(2)).sum::<f64>().sqrt();
    if length > 0.0 { d.map(|c| (f64::from(c) / length) as f32) } else { d }
}

struct Maker {
    rng: SplitMix64,
    dims: [u32; 3],
}

impl Maker {
    fn coordinate(&mut self, axis: usize, place: Place) -> f32 {
        let n = self.dims[axis];
        let last = n.saturating_sub(1);
        match place {
            Place::Plane => self.rng.below(n) as f32,
            Place::Border => (if self.rng.coin() { last } else { 0 }) as f32,
            // Sixteenths make sums and differences exact; anything else makes them round.
            Place::Between if self.rng.coin() => {
                (f64::from(self.rng.below(last)) + f64::from(1 + self.rng.below(15)) / 16.0) as f32
            }
            Place::Between => self.rng.range(0.0, f64::from(last)) as f32,
        }
    }

    fn point(&mut self, places: [Place; 3]) -> [f32; 3] {
        std::array::from_fn(|axis| self.coordinate(axis, places[axis]))
    }

    /// The places in an order of axes drawn by lot.
    fn shuffled(&mut self, mut places: [Place; 3]) -> [Place; 3] {
        places.rotate_left(self.rng.below(3) as usize);
        if self.rng.coin() {
            places.swap(0, 1);
        }
        places
    }

    /// A point around the domain, on a lattice coordinate half of the time.
    fn outside(&mut self) -> [f32; 3] {
        let exact = self.rng.coin();
        let beyond = self.rng.below(3) as usize;
        std::array::from_fn(|axis| {
            let extent = f64::from(self.dims[axis]);
            let c = match (axis == beyond, self.rng.coin()) {
                (false, _) => self.rng.range(-extent, 2.0 * extent),
                (true, false) => self.rng.range(-2.0 * extent, -1.0),
                (true, true) => self.rng.range(extent, 3.0 * extent),
            };
            (if exact { c.round() } else { c }) as f32
        })
    }

    /// A random direction, of small integers half of the time.
    fn direction(&mut self) -> [f32; 3] {
        const LARGEST: u32 = 3;
        loop {
            let integers = self.rng.coin();
            let d: [f32; 3] = std::array::from_fn(|_| {
                if integers {
                    self.rng.below(2 * LARGEST + 1) as f32 - LARGEST as f32
                } else {
                    self.rng.range(-1.0, 1.0) as f32
                }
            });
            if d != [0.0; 3] {
                return d;
            }
        }
    }

    /// Towards a target, reached at `t = 1` or, half of the time, along a unit direction that may miss
    /// it by a rounding error.
    fn through(&mut self, places: [Place; 3]) -> OracleRay {
        let origin = self.outside();
        let direction = difference(self.point(places), origin);
        ray(origin, if self.rng.coin() { direction } else { normalised(direction) })
    }

    fn through_some(&mut self, places: [Place; 3]) -> OracleRay {
        let places = self.shuffled(places);
        self.through(places)
    }

    fn starting_in(&mut self, places: [Place; 3]) -> OracleRay {
        ray(self.point(places), self.direction())
    }

    fn starting_in_some(&mut self, places: [Place; 3]) -> OracleRay {
        let places = self.shuffled(places);
        self.starting_in(places)
    }

    /// From outside, along one axis, or from inside, every fourth time.
    fn parallel(&mut self, place: Place) -> OracleRay {
        let axis = self.rng.below(3) as usize;
        let mut origin = self.point([place; 3]);
        let mut direction = [0.0; 3];
        direction[axis] = self.rng.sign() as f32;
        if self.rng.below(4) > 0 {
            origin[axis] = if direction[axis] > 0.0 { -1.5 } else { self.dims[axis] as f32 + 0.75 };
        }
        ray(origin, direction)
    }

    /// Inside a lattice plane of one axis, from a point of the domain carried back out of it.
    fn in_plane(&mut self, place: Place) -> OracleRay {
        let axis = self.rng.below(3) as usize;
        let mut places = [Place::Between; 3];
        places[axis] = place;
        let target = self.point(places);
        let mut direction = self.direction();
        direction[axis] = 0.0;
        if direction == [0.0; 3] {
            direction[(axis + 1) % 3] = 1.0;
        }
        let back = self.back_out();
        ray(std::array::from_fn(|a| target[a] - back * direction[a]), direction)
    }

    fn diagonal(&mut self) -> OracleRay {
        let target = self.point([Place::Plane; 3]);
        let mut direction: [f32; 3] = std::array::from_fn(|_| self.rng.sign() as f32);
        if self.rng.coin() {
            direction[self.rng.below(3) as usize] = 0.0;
        }
        let back = self.back_out();
        ray(std::array::from_fn(|axis| target[axis] - back * direction[axis]), direction)
    }

    /// A whole number of steps of a direction, most often enough to leave the domain.
    fn back_out(&mut self) -> f32 {
        let largest = self.dims.iter().copied().max().unwrap_or(0);
        self.rng.below(2 * largest) as f32
    }

    fn tiny(&mut self) -> OracleRay {
        const TINY: [f32; 4] = [1e-20, 1e-38, 1e-42, f32::from_bits(1)];
        let places = self.shuffled([Place::Plane, Place::Between, Place::Between]);
        let target = self.point(places);
        let main = self.rng.below(3) as usize;
        let mut direction: [f32; 3] =
            std::array::from_fn(|_| TINY[self.rng.below(4) as usize] * self.rng.sign() as f32);
        direction[main] = self.rng.sign() as f32;
        if self.rng.coin() {
            direction[(main + 1) % 3] = self.rng.range(-1.0, 1.0) as f32;
        }
        let back = self.back_out();
        ray(std::array::from_fn(|axis| target[axis] - back * direction[axis]), direction)
    }

    fn negative_zero(&mut self) -> OracleRay {
        let place = if self.rng.coin() { Place::Plane } else { Place::Between };
        let mut ray = if self.rng.coin() { self.parallel(place) } else { self.in_plane(place) };
        ray.direction = ray.direction.map(|d| if d == 0.0 { -0.0 } else { d });
        ray
    }

    fn far(&mut self) -> OracleRay {
        const DISTANCE: f64 = 1e4;
        let target = self.point([Place::Between; 3]);
        let direction = normalised(self.direction());
        let distance = (DISTANCE * self.rng.range(0.5, 2.0)) as f32;
        let origin: [f32; 3] = std::array::from_fn(|axis| target[axis] - distance * direction[axis]);
        ray(origin, if self.rng.coin() { direction } else { difference(target, origin) })
    }

    fn clipped(&mut self) -> OracleRay {
        let origin = self.outside();
        let direction = difference(self.point([Place::Between; 3]), origin);
        let t_min = self.rng.range(0.5, 1.0) as f32;
        let t_max = self.rng.range(1.0, 2.0) as f32;
        OracleRay { origin, direction, t_min, t_max }
    }
}
