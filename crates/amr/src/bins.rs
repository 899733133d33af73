//! Boxes, by where they are.

use std::collections::HashMap;

use crate::block::for_all;
use crate::cuboid::Cuboid;

/// Boxes of any sizes, each noted in all cubes of a lattice that it has a part in.
pub(crate) struct Bins {
    /// The binary logarithm of the cubes' edge.
    exponent: u32,
    bins: HashMap<[u32; 3], Vec<u32>>,
    places: Vec<Cuboid>,
}

impl Bins {
    /// Cubes are as large as a box is on average, so that there are some times as many notes as boxes; `exponent` tells of the edge where there are none yet.
    pub(crate) fn new(places: impl IntoIterator<Item = Cuboid>, exponent: u32) -> Self {
        let places: Vec<Cuboid> = places.into_iter().collect();
        let volume: f64 = places.iter().map(|place| place.volume() as f64).sum();
        let exponent = match places.len() {
            0 => exponent,
            count => (volume / count as f64).cbrt().log2().ceil() as u32,
        };
        let mut bins = Self { exponent, bins: HashMap::new(), places: Vec::new() };
        places.into_iter().for_each(|place| bins.push(place));
        bins
    }

    /// Its number is that of those before it.
    pub(crate) fn push(&mut self, place: Cuboid) {
        let number = self.places.len() as u32;
        let [low, count] = self.range(&place);
        for_all(count, |at| {
            self.bins.entry(std::array::from_fn(|a| low[a] + at[a])).or_default().push(number);
        });
        self.places.push(place);
    }

    /// The numbers of the boxes that have a volume in common with one, in order.
    pub(crate) fn over(&self, place: &Cuboid) -> Vec<u32> {
        let mut found = Vec::new();
        let [low, count] = self.range(place);
        // There may be more cubes than boxes.
        if count.iter().map(|&n| u64::from(n)).product::<u64>() > self.places.len() as u64 {
            found.extend(0..self.places.len() as u32);
        } else {
            for_all(count, |at| {
                let bin = self.bins.get(&std::array::from_fn(|a| low[a] + at[a]));
                found.extend(bin.into_iter().flatten());
            });
            found.sort_unstable();
            found.dedup();
        }
        found.retain(|&number| self.places[number as usize].common(place).is_some());
        found
    }

    /// The lowest cube that a box has a part in, and their number along each axis.
    fn range(&self, place: &Cuboid) -> [[u32; 3]; 2] {
        let low = place.low.map(|c| c >> self.exponent);
        [low, std::array::from_fn(|a| ((place.high[a] - 1) >> self.exponent) - low[a] + 1)]
    }
}
