//! A writer of TIFF files.

use isoray_io::{Endian, SampleType};

use crate::make::{body, zlib};

/// Compressions by their numbers in the file.
pub(crate) const COMPRESSIONS: [u16; 5] = [1, 5, 8, 32773, 32946];

/// A page of the file.
#[derive(Clone, Debug)]
pub(crate) struct Page {
    pub(crate) size: [u32; 2],
    pub(crate) sample: SampleType,
    pub(crate) components: u16,
    pub(crate) compression: u16,
    /// Rows in a strip.
    pub(crate) rows: u32,
    /// Width and height of a tile, instead of strips.
    pub(crate) tile: Option<u32>,
    /// NewSubfileType.
    pub(crate) kind: u32,
    pub(crate) description: &'static str,
    /// Dots and unit along x and y.
    pub(crate) resolution: Option<[[u32; 2]; 2]>,
    /// Samples in the byte order of the file.
    pub(crate) samples: Vec<u8>,
}

/// The pages of a 5×4×3 stack.
pub(crate) fn pages(sample: SampleType, endian: Endian, components: u16) -> Vec<Page> {
    let samples = body(sample, endian, components.into(), true);
    let page = |samples: &[u8]| Page {
        size: [5, 4],
        sample,
        components,
        compression: 1,
        rows: 4,
        tile: None,
        kind: 2,
        description: "",
        resolution: None,
        samples: samples.to_vec(),
    };
    samples.chunks(samples.len() / 3).map(page).collect()
}

/// LZW codes of nine bits: every byte stands for itself, and the table is cleared before codes grow.
fn lzw(bytes: &[u8]) -> Vec<u8> {
    const CLEAR: u16 = 256;
    const END: u16 = 257;
    let mut codes = Vec::new();
    for part in bytes.chunks(100) {
        codes.push(CLEAR);
        codes.extend(part.iter().map(|&b| u16::from(b)));
    }
    codes.push(END);
    let bits: Vec<u8> = codes.iter().flat_map(|c| (0..9).rev().map(move |i| (c >> i & 1) as u8)).collect();
    bits.chunks(8).map(|byte| byte.iter().enumerate().fold(0, |sum, (i, bit)| sum | bit << (7 - i))).collect()
}

impl Page {
    fn pack(&self, bytes: &[u8]) -> Vec<u8> {
        match self.compression {
            5 => lzw(bytes),
            8 | 32946 => zlib(bytes),
            // Runs of different bytes, each after their number less one.
            32773 => bytes.chunks(100).flat_map(|c| [&[c.len() as u8 - 1], c].concat()).collect(),
            _ => bytes.to_vec(),
        }
    }

    /// Bytes of one pixel.
    fn pixel(&self) -> usize {
        self.sample.size() * usize::from(self.components)
    }

    fn chunks(&self) -> Vec<Vec<u8>> {
        let row = self.size[0] as usize * self.pixel();
        let Some(side) = self.tile else {
            return self.samples.chunks(row * self.rows as usize).map(|strip| self.pack(strip)).collect();
        };
        let mut tiles = Vec::new();
        for y0 in (0..self.size[1]).step_by(side as usize) {
            for x0 in (0..self.size[0]).step_by(side as usize) {
                let mut tile = Vec::new();
                for y in y0..y0 + side {
                    for x in x0..x0 + side {
                        let at = y as usize * row + x as usize * self.pixel();
                        let inside = x < self.size[0] && y < self.size[1];
                        let pixel = if inside { &self.samples[at..at + self.pixel()] } else { &[9; 64] };
                        tile.extend(&pixel[..self.pixel()]);
                    }
                }
                tiles.push(self.pack(&tile));
            }
        }
        tiles
    }

    /// Tag, type and values; types are 2 for text, 3 and 4 for 16 and 32 bits, 5 for a fraction.
    fn tags(&self, offsets: &[u32], counts: &[u32]) -> Vec<(u16, u16, Vec<u32>)> {
        let format = match self.sample {
            SampleType::F32 | SampleType::F64 => 3,
            _ if self.sample.name().starts_with('i') => 2,
            _ => 1,
        };
        let n = usize::from(self.components);
        let bits = self.sample.size() as u32 * 8;
        let colour = if n == 3 { 2 } else { 1 };
        let (offsets, counts) = (offsets.to_vec(), counts.to_vec());
        let mut tags = vec![
            (254, 4, vec![self.kind]),
            (256, 4, vec![self.size[0]]),
            (257, 4, vec![self.size[1]]),
            (258, 3, vec![bits; n]),
            (259, 3, vec![self.compression.into()]),
            (262, 3, vec![colour]),
            (277, 3, vec![n as u32]),
            (339, 3, vec![format; n]),
        ];
        match self.tile {
            None => tags.extend([(273, 4, offsets), (278, 4, vec![self.rows]), (279, 4, counts)]),
            Some(side) => {
                tags.extend([
                    (322, 4, vec![side]),
                    (323, 4, vec![side]),
                    (324, 4, offsets),
                    (325, 4, counts),
                ]);
            }
        }
        if !self.description.is_empty() {
            tags.push((270, 2, self.description.bytes().chain([0]).map(u32::from).collect()));
        }
        if let Some([x, y]) = self.resolution {
            tags.extend([(282, 5, x.to_vec()), (283, 5, y.to_vec())]);
        }
        tags.sort();
        tags
    }
}

/// The bytes of a file with these pages.
pub(crate) fn tiff(pages: &[Page], endian: Endian, big: bool) -> Vec<u8> {
    let number = |n: u64, size: usize| {
        let mut bytes = n.to_le_bytes()[..size].to_vec();
        if endian == Endian::Big {
            bytes.reverse();
        }
        bytes
    };
    let wide = if big { 8 } else { 4 };
    let mut out = if endian == Endian::Big { b"MM".to_vec() } else { b"II".to_vec() };
    out.extend(number(if big { 43 } else { 42 }, 2));
    if big {
        out.extend([number(8, 2), number(0, 2)].concat());
    }
    for page in pages {
        // The place of the page's directory is written where the one before says so.
        let link = out.len();
        out.extend(vec![0; wide]);
        let (mut offsets, mut counts) = (vec![], vec![]);
        for chunk in page.chunks() {
            offsets.push(out.len() as u32);
            counts.push(chunk.len() as u32);
            out.extend(chunk);
        }
        let mut entries = Vec::new();
        let tags = page.tags(&offsets, &counts);
        for (tag, kind, values) in &tags {
            let size = match kind {
                2 => 1,
                3 => 2,
                _ => 4,
            };
            let mut bytes: Vec<u8> = values.iter().flat_map(|&v| number(v.into(), size)).collect();
            let count = if *kind == 5 { 1 } else { values.len() };
            if bytes.len() > wide {
                let place = number(out.len() as u64, wide);
                out.extend(std::mem::replace(&mut bytes, place));
            }
            bytes.resize(wide, 0);
            entries.extend(
                [number((*tag).into(), 2), number((*kind).into(), 2), number(count as u64, wide)].concat(),
            );
            entries.extend(bytes);
        }
        let directory = number(out.len() as u64, wide);
        out[link..link + wide].copy_from_slice(&directory);
        out.extend(number(tags.len() as u64, if big { 8 } else { 2 }));
        out.extend(entries);
    }
    out.extend(vec![0; wide]);
    out
}

/// Valid files to damage.
pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let mut pages = pages(SampleType::U16, Endian::Little, 1);
    let plain = tiff(&pages, Endian::Little, false);
    pages.iter_mut().for_each(|page| (page.compression, page.tile) = (8, Some(16)));
    let tiles = tiff(&pages, Endian::Little, true);
    pages.iter_mut().for_each(|page| (page.compression, page.tile, page.rows) = (5, None, 2));
    let strips = tiff(&pages, Endian::Little, false);
    pages.iter_mut().for_each(|page| page.compression = 32773);
    vec![plain, tiles, strips, tiff(&pages, Endian::Little, false)]
}
