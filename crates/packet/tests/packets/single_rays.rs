//! Packets against single rays, bit for bit.

use isoray_build::build;
use isoray_grid::{DenseVolume, Dims, Scalar};
use isoray_octree::OctreeVolume;
use isoray_oracle::{RayKind, SplitMix64, adversarial_isovalue, adversarial_lattice};
use isoray_packet::{PacketTracer, TracePackets, Traversal};
use isoray_trace::{Hit, Ray, Tracer};

fn volume<T: Scalar>(dims: [u32; 3], samples: &[T]) -> OctreeVolume<T> {
    let mut source = DenseVolume::new(Dims::new(dims).unwrap(), samples).unwrap();
    build(&mut source, glam::DAffine3::IDENTITY, |_| {}).unwrap()
}

/// All bits of a hit.
fn bits(hit: &Hit) -> ([u32; 12], [u32; 3], bool) {
    let [x, y, z] = hit.local;
    let mut numbers = [0; 12];
    for (bits, number) in numbers.iter_mut().zip([hit.t, x, y, z].into_iter().chain(hit.corners)) {
        *bits = number.to_bits();
    }
    (numbers, hit.cell, hit.is_entering)
}

/// Traces `rays` both ways, and others from where they hit; how many hit, and how many of the others are occluded.
fn compare<T: Scalar>(
    packets: &mut PacketTracer<'_, T>,
    single: &mut Tracer<'_, T>,
    rays: &[Ray],
    isovalue: f32,
    what: &str,
) -> [usize; 2] {
    let traversal = crate::traversals::one_of(rays.len());
    let mut hits = vec![None; rays.len()];
    packets.first_hits(rays, isovalue, traversal, &mut hits, &mut ());
    for (n, (ray, hit)) in rays.iter().zip(&hits).enumerate() {
        let expected = single.first_hit(ray, isovalue);
        let [found, expected] = [hit, &expected].map(|hit| hit.as_ref().map(bits));
        assert_eq!(found, expected, "{what}, ray {n} of {}: {ray:?}, isovalue {isovalue}", rays.len());
    }
    let hits: Vec<Hit> = hits.into_iter().flatten().collect();
    if let Some(hull) = crate::traversals::hull(rays) {
        assert!(hits.is_empty() || packets.may_hit(&hull, isovalue, &mut ()), "{what}: {hull:?}");
    }
    let mut random = SplitMix64::new(rays.len() as u64 + hits.len() as u64);
    let occluded = crate::shadows::compare(packets, single, &hits, isovalue, &mut random);
    [hits.len(), occluded]
}

/// As many rays as one likes through a screen, from one point or side by side.
fn screen(random: &mut SplitMix64, dims: [u32; 3], count: usize) -> Vec<Ray> {
    let within = |random: &mut SplitMix64, by: f64| -> [f64; 3] {
        dims.map(|n| random.range(-by * f64::from(n), (1.0 + by) * f64::from(n)))
    };
    let outside = if random.coin() { 0.0 } else { 2.0 };
    let (eye, target) = (within(random, outside), within(random, 0.0));
    let width = random.range(-12.0, 1.0).exp2();
    let is_parallel = random.below(4) == 0;
    let across = [(); 2].map(|()| [(); 3].map(|()| random.range(-1.0, 1.0)));
    let ray = |n: usize| {
        let [u, v] = [n % 8, n / 8].map(|c| width * (c as f64 - 3.5));
        let offset = |a: usize| u * across[0][a] + v * across[1][a];
        let forward = |a: usize| target[a] - eye[a];
        let (origin, direction): ([f64; 3], [f64; 3]) = match is_parallel {
            true => ([0, 1, 2].map(|a| eye[a] + 16.0 * offset(a)), [0, 1, 2].map(forward)),
            false => (eye, [0, 1, 2].map(|a| forward(a) + 16.0 * offset(a))),
        };
        let [origin, direction] = [origin, direction].map(|v| v.map(|c| c as f32));
        Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    };
    (0..count).map(ray).collect()
}

/// Packets of every kind through one kind of volume. The numbers of rays, of hits, and of rays from there that are occluded.
fn check<T: Scalar>(seeds: std::ops::Range<u64>, convert: impl Fn(f32) -> T) -> [usize; 3] {
    let (mut rays_in_all, mut hits, mut occluded) = (0, 0, 0);
    for seed in seeds {
        let mut random = SplitMix64::new(seed);
        let side = |n: u64| 1 + (seed.wrapping_mul(n) % 37) as u32;
        let dims = [side(7), side(11), side(13)];
        let samples: Vec<T> = adversarial_lattice(dims, seed).iter().map(|&s| convert(s)).collect();
        let widened: Vec<f32> = samples.iter().map(|s| s.to_f32()).collect();
        let built = volume(dims, &samples);
        let view = built.view();
        let (mut packets, mut single) = (PacketTracer::new(&view), Tracer::new(&view));
        for n in 0..12 {
            let isovalue = adversarial_isovalue(&widened, seed * 17 + n);
            let count = 1 + random.below(90) as usize;
            let mut rays = screen(&mut random, dims, count);
            let mut both = |rays: &[Ray], what: &str| {
                let what = format!("{what}, seed {seed}");
                let found = compare(&mut packets, &mut single, rays, isovalue, &what);
                hits += found[0];
                occluded += found[1];
            };
            both(&rays, "screen");
            // Among them rays of any other kind: parallel to planes, along edges, not of numbers, short.
            for ray in &mut rays {
                if random.below(3) > 0 {
                    continue;
                }
                let kind = RayKind::ALL[random.below(RayKind::ALL.len() as u32) as usize];
                let other = kind.generate(dims, random.below(1 << 30).into());
                *ray = Ray {
                    origin: other.origin,
                    direction: other.direction,
                    t_min: other.t_min,
                    t_max: other.t_max,
                };
                match random.below(30) {
                    0 => ray.direction[random.below(3) as usize] = f32::NAN,
                    1 => ray.origin[random.below(3) as usize] = f32::INFINITY,
                    2 => ray.t_max = f32::NAN,
                    3 => ray.direction = [0.0; 3],
                    4 => ray.direction = ray.direction.map(|d| d * 1e-30),
                    5 => ray.origin = ray.origin.map(|o| o + 1e7),
                    6 => ray.t_min = f32::NEG_INFINITY,
                    _ => {}
                }
            }
            both(&rays, "mixed");
            rays_in_all += 2 * rays.len();
        }
    }
    [rays_in_all, hits, occluded]
}

#[test]
fn packets_have_the_hits_of_single_rays() {
    let counts = [
        ("f32", check(0..80, |s| s)),
        ("u8", check(1000..1080, |s| s.clamp(0.0, 255.0) as u8)),
        ("i16", check(2000..2080, |s| (s * 100.0 - 50.0).clamp(-32768.0, 32767.0) as i16)),
    ];
    for (scalar, [rays, hits, occluded]) in counts {
        println!("{scalar}: {rays} rays, {hits} hits, {occluded} of three from each occluded");
        assert!(hits > rays / 20, "{scalar}: {hits} of {rays} hit");
        assert!(occluded > hits / 2 && occluded < 3 * hits - hits / 2, "{scalar}: {occluded}");
    }
}

#[test]
fn no_rays_and_no_surface() {
    let built = volume([5, 5, 5], &[7u8; 125]);
    let view = built.view();
    let mut packets = PacketTracer::new(&view);
    packets.first_hits(&[], 3.0, Traversal::Auto, &mut [], &mut ());
    let ray = Ray { origin: [2.0; 3], direction: [1.0; 3], t_min: 0.0, t_max: f32::INFINITY };
    let mut hits = [None; 3];
    for isovalue in [3.0, 7.0, 300.0, f32::NAN] {
        packets.first_hits(&[ray; 3], isovalue, Traversal::Masked, &mut hits, &mut ());
        assert_eq!(hits, [None; 3]);
    }
}
