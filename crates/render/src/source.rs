//! What can be drawn.

use isoray_amr::{Mesh, MeshTracer, MeshVolumeTracer};
use isoray_grid::{DenseVolume, Dims, GridVolume, Samples, Scalar};
use isoray_octree::OctreeView;
use isoray_octree::lod::DetailView;
use isoray_packet::{DetailPacketTracer, FarShadows, PacketTracer, TracePackets};
use isoray_preint::{Integrate, Lighting, Radiance, Visibility};
use isoray_trace::{Counters, DenseVolumeTracer, GridTracer, Ray, VolumeTracer};

use crate::scene::LEVEL_COLORS;

/// A volume whose isosurfaces can be drawn: an octree volume, samples with macrocells, or an adaptive mesh.
pub trait SurfaceSource: Sync {
    /// What each thread makes of it.
    type SurfaceTracer<'s>: TracePackets + Send
    where
        Self: 's;

    /// Size of the lattice.
    fn dims(&self) -> Dims;

    /// A tracer of it.
    fn surface_tracer(&self) -> Self::SurfaceTracer<'_>;
}

impl<'a, T: Scalar> SurfaceSource for OctreeView<'a, T> {
    type SurfaceTracer<'s>
        = PacketTracer<'s, T>
    where
        Self: 's;

    fn dims(&self) -> Dims {
        OctreeView::dims(self)
    }

    fn surface_tracer(&self) -> PacketTracer<'_, T> {
        PacketTracer::new(self)
    }
}

/// As it is seen in one picture, from one eye.
impl<'a, T: Scalar> SurfaceSource for DetailView<'a, T> {
    type SurfaceTracer<'s>
        = DetailPacketTracer<'s, T>
    where
        Self: 's;

    fn dims(&self) -> Dims {
        self.volume().dims()
    }

    fn surface_tracer(&self) -> DetailPacketTracer<'_, T> {
        DetailPacketTracer::new(self)
    }
}

/// A volume, with shadows that come through coarser levels of detail from afar; see [`FarShadows`].
#[derive(Clone, Copy, Debug)]
pub struct FarShadowed<'v, 'a, S, T: Scalar> {
    /// What the picture shows.
    pub picture: &'v S,
    /// What far shadows come from: the same volume, as it is seen from the same eye.
    pub far: &'v DetailView<'a, T>,
}

impl<'a, S: SurfaceSource, T: Scalar> SurfaceSource for FarShadowed<'_, 'a, S, T> {
    type SurfaceTracer<'s>
        = FarShadows<'s, T, S::SurfaceTracer<'s>>
    where
        Self: 's;

    fn dims(&self) -> Dims {
        self.picture.dims()
    }

    fn surface_tracer(&self) -> FarShadows<'_, T, S::SurfaceTracer<'_>> {
        FarShadows::new(self.picture.surface_tracer(), self.far)
    }
}

impl<S: Samples> SurfaceSource for GridVolume<S> {
    type SurfaceTracer<'s>
        = GridTracer<'s, S>
    where
        Self: 's;

    fn dims(&self) -> Dims {
        self.samples().dims()
    }

    fn surface_tracer(&self) -> GridTracer<'_, S> {
        GridTracer::new(self)
    }
}

impl SurfaceSource for Mesh {
    type SurfaceTracer<'s>
        = MeshTracer<'s>
    where
        Self: 's;

    fn dims(&self) -> Dims {
        Mesh::dims(self)
    }

    fn surface_tracer(&self) -> MeshTracer<'_> {
        MeshTracer::new(self)
    }
}

/// A volume that rays can be integrated through: an octree volume, a dense array with its macrocells, or an adaptive mesh.
pub trait VolumeSource: Sync {
    /// What each thread makes of it.
    type Tracer<'s>: Send
    where
        Self: 's;

    /// Size of the lattice.
    fn dims(&self) -> Dims;

    /// Corner values of the cell at `cell`, which is one of the lattice's, x fastest.
    fn corners(&self, cell: [u32; 3]) -> [f32; 8];

    /// A tracer of what is `visible`.
    fn tracer<'s>(&'s self, visible: &Visibility) -> Self::Tracer<'s>;

    /// What `scheme` gathers along each of a few rays in index space, a unit of whose parameter is one unit of length in the world. `lighting` tells
    /// what a ray is lit by, and `take` is told what it gathers, both with its number.
    fn integrate(
        tracer: &mut Self::Tracer<'_>,
        rays: &[Ray],
        scheme: &impl Integrate,
        lighting: impl Fn(usize) -> Option<Lighting>,
        counters: &mut impl Counters,
        take: impl FnMut(usize, Radiance),
    );
}

impl<'a, T: Scalar> VolumeSource for OctreeView<'a, T> {
    type Tracer<'s>
        = VolumeTracer<'s, T>
    where
        Self: 's;

    fn dims(&self) -> Dims {
        OctreeView::dims(self)
    }

    fn corners(&self, cell: [u32; 3]) -> [f32; 8] {
        OctreeView::corners(self, cell).map(T::to_f32)
    }

    fn tracer<'s>(&'s self, visible: &Visibility) -> VolumeTracer<'s, T> {
        VolumeTracer::new(self, visible)
    }

    fn integrate(
        tracer: &mut VolumeTracer<'_, T>,
        rays: &[Ray],
        scheme: &impl Integrate,
        lighting: impl Fn(usize) -> Option<Lighting>,
        counters: &mut impl Counters,
        take: impl FnMut(usize, Radiance),
    ) {
        tracer.integrate_all(rays, 1.0, scheme, lighting, counters, take);
    }
}

impl<'a, T: Scalar> VolumeSource for GridVolume<DenseVolume<'a, T>> {
    type Tracer<'s>
        = DenseVolumeTracer<'s, T>
    where
        Self: 's;

    fn dims(&self) -> Dims {
        self.samples().dims()
    }

    fn corners(&self, cell: [u32; 3]) -> [f32; 8] {
        self.samples().corners(cell).map(T::to_f32)
    }

    fn tracer<'s>(&'s self, visible: &Visibility) -> DenseVolumeTracer<'s, T> {
        DenseVolumeTracer::new(self, visible)
    }

    fn integrate(
        tracer: &mut DenseVolumeTracer<'_, T>,
        rays: &[Ray],
        scheme: &impl Integrate,
        lighting: impl Fn(usize) -> Option<Lighting>,
        counters: &mut impl Counters,
        take: impl FnMut(usize, Radiance),
    ) {
        let integrate =
            |ray: &Ray, lighting: Option<&Lighting>| tracer.integrate(ray, 1.0, scheme, lighting, counters);
        one_by_one(rays, lighting, integrate, take);
    }
}

/// What is gathered along each ray, alone.
#[inline(always)]
fn one_by_one(
    rays: &[Ray],
    lighting: impl Fn(usize) -> Option<Lighting>,
    mut integrate: impl FnMut(&Ray, Option<&Lighting>) -> Radiance,
    mut take: impl FnMut(usize, Radiance),
) {
    for (n, ray) in rays.iter().enumerate() {
        take(n, integrate(ray, lighting(n).as_ref()));
    }
}

/// Cells are those of the finest lattice.
impl VolumeSource for Mesh {
    type Tracer<'s>
        = MeshVolumeTracer<'s>
    where
        Self: 's;

    fn dims(&self) -> Dims {
        Mesh::dims(self)
    }

    fn corners(&self, cell: [u32; 3]) -> [f32; 8] {
        std::array::from_fn(|n| {
            let point = std::array::from_fn(|a| f64::from(cell[a]) + (n >> a & 1) as f64);
            // Towards the cell.
            self.value(point, 7 ^ n as u32).map_or(f32::NAN, |value| value as f32)
        })
    }

    fn tracer<'s>(&'s self, visible: &Visibility) -> MeshVolumeTracer<'s> {
        MeshVolumeTracer::new(self, visible)
    }

    fn integrate(
        tracer: &mut MeshVolumeTracer<'_>,
        rays: &[Ray],
        scheme: &impl Integrate,
        lighting: impl Fn(usize) -> Option<Lighting>,
        counters: &mut impl Counters,
        take: impl FnMut(usize, Radiance),
    ) {
        let integrate =
            |ray: &Ray, lighting: Option<&Lighting>| tracer.integrate(ray, 1.0, scheme, lighting, counters);
        one_by_one(rays, lighting, integrate, take);
    }
}

/// An adaptive mesh whose cells have the colours of their levels, [`LEVEL_COLORS`]: schemes must show all in
/// [white](isoray_preint::TransferFunction::in_white).
#[derive(Clone, Copy, Debug)]
pub struct ByLevel<'m>(pub &'m Mesh);

impl VolumeSource for ByLevel<'_> {
    type Tracer<'s>
        = MeshVolumeTracer<'s>
    where
        Self: 's;

    fn dims(&self) -> Dims {
        self.0.dims()
    }

    fn corners(&self, cell: [u32; 3]) -> [f32; 8] {
        VolumeSource::corners(self.0, cell)
    }

    fn tracer<'s>(&'s self, visible: &Visibility) -> MeshVolumeTracer<'s> {
        VolumeSource::tracer(self.0, visible)
    }

    fn integrate(
        tracer: &mut MeshVolumeTracer<'_>,
        rays: &[Ray],
        scheme: &impl Integrate,
        lighting: impl Fn(usize) -> Option<Lighting>,
        counters: &mut impl Counters,
        take: impl FnMut(usize, Radiance),
    ) {
        let scheme = (scheme, &LEVEL_COLORS.map(|color| color.to_array())[..]);
        let integrate = |ray: &Ray, lighting: Option<&Lighting>| {
            tracer.integrate_levels(ray, 1.0, scheme, lighting, counters)
        };
        one_by_one(rays, lighting, integrate, take);
    }
}
