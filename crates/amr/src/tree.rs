//! The kd-tree of homogeneous boxes (Marchesin and Colin de Verdière 2009, section 4.1).

use crate::cuboid::Cuboid;
use crate::overlap::Placed;

/// How the plane is chosen that cuts a box in two.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SplitRule {
    /// So that both parts are as homogeneous as can be: the least volume of what a part would have to give away to be all of one kind, covered by finer
    /// cells or not; as an expectation (Gini's).
    #[default]
    Homogeneity,
    /// By the surfaces of both parts, which tell how many rays meet them, and how many finer patches are left in each (the surface-area heuristic).
    SurfaceArea,
}

/// A node; the root is the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Node {
    /// A plane across an axis, and the nodes on both of its sides.
    Split { axis: u8, plane: u32, parts: [u32; 2] },
    /// A box of cells of one level, by its number.
    Leaf(u32),
}

/// A box of cells of one level.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Leaf {
    pub(crate) place: Cuboid,
    pub(crate) level: u32,
    /// The patches of that level in it.
    pub(crate) patches: Vec<u32>,
}

/// The nodes, and what the leaves are.
pub(crate) struct Tree {
    pub(crate) nodes: Vec<Node>,
    pub(crate) leaves: Vec<Leaf>,
}

/// Why there is no tree.
pub(crate) enum NoTree {
    /// A box that nothing covers.
    Gap(Cuboid),
    /// What finer patches cover in a box is not made of whole cells of this level.
    Cuts(Cuboid, u32),
}

/// Cells along the edge of a box of one level over which it is cut all the same, so that threads have something to share.
const MOST_CELLS: u32 = 64;

/// Where to cut a box.
struct Cut {
    axis: usize,
    plane: u32,
}

/// What to do with a box.
enum Verdict {
    Cut(Cut),
    /// It is of one level.
    Leaf(u32),
}

impl Tree {
    /// A tree over `domain`. Of each of the `levels`, `parts` are boxes that do not overlap, and that all cells of it and of finer ones fill; cells of level `l`
    /// have the edge `1 << exponent(l)`.
    ///
    /// A box is homogeneous, which is what the paper leaves open, if it is full of cells of one level and finer ones, and has none that are finer. Else it is cut at a
    /// face of what is finer, so that the tree comes to an end. Costs O(n log² n) for `n` patches: planes are found by sorting, and one that leaves more than seven
    /// eighths of many patches on one side is not taken if there is another.
    pub(crate) fn new(
        domain: Cuboid,
        parts: &[Placed],
        levels: u32,
        exponent: impl Fn(u32) -> u32,
        rule: SplitRule,
    ) -> Result<Self, NoTree> {
        let mut tree = Self { nodes: vec![Node::Leaf(0)], leaves: Vec::new() };
        let mut pending: Vec<(u32, Cuboid, Vec<Placed>)> = vec![(0, domain, parts.to_vec())];
        while let Some((node, place, parts)) = pending.pop() {
            let Cut { axis, plane } = match judge(place, &parts, levels, &exponent, rule)? {
                Verdict::Cut(cut) => cut,
                Verdict::Leaf(level) => {
                    let patches = parts.iter().filter(|part| part.level == level).map(|part| part.patch);
                    tree.nodes[node as usize] = Node::Leaf(tree.leaves.len() as u32);
                    tree.leaves.push(Leaf { place, level, patches: patches.collect() });
                    continue;
                }
            };
            let first = tree.nodes.len() as u32;
            tree.nodes[node as usize] = Node::Split { axis: axis as u8, plane, parts: [first, first + 1] };
            for (n, side) in (0..).zip(place.split(axis, plane)) {
                tree.nodes.push(Node::Leaf(0));
                let within = |part: &Placed| Some(Placed { place: part.place.common(&side)?, ..*part });
                pending.push((first + n, side, parts.iter().filter_map(within).collect()));
            }
        }
        Ok(tree)
    }

    /// The leaf that holds the octant at `p` towards which `octant` points: bit `a` for larger coordinates. Both are of the domain.
    #[inline]
    pub(crate) fn find(nodes: &[Node], p: [u32; 3], octant: u32) -> u32 {
        let mut node = nodes[0];
        loop {
            match node {
                Node::Leaf(leaf) => return leaf,
                Node::Split { axis, plane, parts } => {
                    let at = p[axis as usize];
                    let is_above = at > plane || at == plane && octant >> axis & 1 == 1;
                    node = nodes[parts[usize::from(is_above)] as usize];
                }
            }
        }
    }
}

fn judge(
    place: Cuboid,
    parts: &[Placed],
    levels: u32,
    exponent: impl Fn(u32) -> u32,
    rule: SplitRule,
) -> Result<Verdict, NoTree> {
    let mut of_level = Vec::new();
    for level in 0..levels {
        of_level.clear();
        of_level.extend(parts.iter().filter(|part| part.level == level).map(|part| part.place));
        if of_level.iter().map(Cuboid::volume).sum::<u64>() == place.volume() {
            continue;
        }
        // The level before fills the box, and has cells in it that no finer ones cover.
        let Some(coarser) = level.checked_sub(1) else { return Err(NoTree::Gap(place)) };
        if of_level.is_empty() {
            return Ok(leaf_or_halves(place, coarser, exponent(coarser)));
        }
        let cut = best_cut(place, &of_level, 1 << exponent(coarser), rule);
        return cut.map(Verdict::Cut).ok_or(NoTree::Cuts(place, coarser));
    }
    Ok(leaf_or_halves(place, levels - 1, exponent(levels - 1)))
}

fn leaf_or_halves(place: Cuboid, level: u32, exponent: u32) -> Verdict {
    let most = MOST_CELLS << exponent;
    let long = (0..3).find(|&a| place.edges()[a] > most);
    long.map_or(Verdict::Leaf(level), |axis| Verdict::Cut(Cut { axis, plane: place.low[axis] + most }))
}

/// What is known of one side of a plane.
#[derive(Clone, Copy, Default)]
struct Side {
    covered: f64,
    volume: f64,
    half_surface: f64,
    parts: usize,
}

/// The best plane among those faces of parts inside the box that lie on the lattice of cells with this `edge`, if there are any.
fn best_cut(place: Cuboid, parts: &[Cuboid], edge: u32, rule: SplitRule) -> Option<Cut> {
    let mut best: Option<((bool, f64, u32), Cut)> = None;
    let all: f64 = parts.iter().map(|part| part.volume() as f64).sum();
    for axis in 0..3 {
        let face = |part: &Cuboid, corner: [u32; 3]| {
            (corner[axis], part.volume() as f64 / f64::from(part.edges()[axis]))
        };
        let mut lows: Vec<(u32, f64)> = parts.iter().map(|part| face(part, part.low)).collect();
        let mut highs: Vec<(u32, f64)> = parts.iter().map(|part| face(part, part.high)).collect();
        lows.sort_unstable_by_key(|face| face.0);
        highs.sort_unstable_by_key(|face| face.0);
        let mut planes: Vec<u32> = lows.iter().chain(&highs).map(|face| face.0).collect();
        planes.sort_unstable();
        planes.dedup();
        let (mut begun, mut ended) = (0, 0);
        // Below the plane: what is covered; and of a slice just below it.
        let (mut covered, mut slice, mut last) = (0.0, 0.0, place.low[axis]);
        for plane in planes {
            covered += slice * f64::from(plane - last);
            last = plane;
            while let Some(&(_, area)) = highs.get(ended).filter(|face| face.0 <= plane) {
                slice -= area;
                ended += 1;
            }
            if plane > place.low[axis] && plane < place.high[axis] && plane.is_multiple_of(edge) {
                let halves = place.split(axis, plane);
                let side = |n: usize, covered: f64, parts: usize| Side {
                    covered,
                    volume: halves[n].volume() as f64,
                    half_surface: halves[n].half_surface(),
                    parts,
                };
                let sides = [side(0, covered, begun), side(1, all - covered, parts.len() - ended)];
                let is_lopsided = sides.iter().any(|s| 8 * s.parts > 7 * parts.len() + 8);
                let off_middle = (2 * plane).abs_diff(place.low[axis] + place.high[axis]);
                let cost = (is_lopsided, cost(&sides, rule), off_middle);
                if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                    best = Some((cost, Cut { axis, plane }));
                }
            }
            while let Some(&(_, area)) = lows.get(begun).filter(|face| face.0 <= plane) {
                slice += area;
                begun += 1;
            }
        }
    }
    best.map(|(_, cut)| cut)
}

fn cost(sides: &[Side; 2], rule: SplitRule) -> f64 {
    let of_side = |side: &Side| match rule {
        SplitRule::Homogeneity => side.covered * (1.0 - side.covered / side.volume),
        SplitRule::SurfaceArea => side.half_surface * side.parts as f64,
    };
    sides.iter().map(of_side).sum()
}
