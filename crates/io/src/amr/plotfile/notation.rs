//! Boxes and number formats as BoxLib prints them: `((0,0,0) (15,15,31) (0,0,0))`.

use std::str::FromStr;

use crate::amr::IndexBox;
use crate::sample::{Endian, SampleType};

/// Reads numbers and punctuation; white space may stand anywhere between them.
#[derive(Clone, Debug)]
pub(super) struct Notation<'a>(&'a str);

/// A box of values in one, two, three, … dimensions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct TypedBox {
    low: Vec<i64>,
    high: Vec<i64>,
    /// For each axis, 0 if the values are between the corners of cells, and 1 if they are at them.
    at_corners: Vec<i64>,
}

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RealFormat {
    pub(super) sample: SampleType,
    pub(super) endian: Endian,
}

impl<'a> Notation<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self(text)
    }

    pub(super) fn rest(&self) -> &'a str {
        self.0.trim_start()
    }

    fn eat(&mut self, expected: char) -> Option<()> {
        self.0 = self.rest().strip_prefix(expected)?;
        Some(())
    }

    pub(super) fn number<T: FromStr>(&mut self) -> Option<T> {
        let text = self.rest();
        let end = text.find(|c: char| c.is_whitespace() || "(),".contains(c)).unwrap_or(text.len());
        let number = text[..end].parse().ok()?;
        self.0 = &text[end..];
        Some(number)
    }

    /// `(1,2,3)`, with commas or spaces.
    pub(super) fn vector<T: FromStr>(&mut self) -> Option<Vec<T>> {
        self.eat('(')?;
        let mut numbers = vec![self.number()?];
        while self.eat(')').is_none() {
            let _comma = self.eat(',');
            numbers.push(self.number()?);
        }
        Some(numbers)
    }

    /// The low corner, the high one and, but for the oldest files, the kind of values.
    pub(super) fn typed_box(&mut self) -> Option<TypedBox> {
        self.eat('(')?;
        let (low, high) = (self.vector()?, self.vector()?);
        let at_corners = if self.rest().starts_with('(') { self.vector()? } else { vec![0; low.len()] };
        self.eat(')')?;
        (low.len() == high.len() && low.len() == at_corners.len()).then_some(TypedBox {
            low,
            high,
            at_corners,
        })
    }

    /// The layout of the bits of a number, and the order of its bytes.
    pub(super) fn real_format(&mut self) -> Option<RealFormat> {
        self.eat('(')?;
        let bits = self.counted()?;
        self.eat(',')?;
        let order = self.counted()?;
        self.eat(')')?;
        let sample = match bits.as_slice() {
            [64, 11, 52, 0, 1, 12, 0, 1023] => SampleType::F64,
            [32, 8, 23, 0, 1, 9, 0, 127] => SampleType::F32,
            _ => return None,
        };
        let bytes = sample.size() as u64;
        let endian = if order.iter().copied().eq(1..=bytes) {
            Endian::Big
        } else if order.iter().copied().eq((1..=bytes).rev()) {
            Endian::Little
        } else {
            return None;
        };
        Some(RealFormat { sample, endian })
    }

    /// `(3, (1 2 3))`.
    fn counted(&mut self) -> Option<Vec<u64>> {
        self.eat('(')?;
        let count: usize = self.number()?;
        self.eat(',')?;
        let numbers = self.vector()?;
        self.eat(')')?;
        (numbers.len() == count).then_some(numbers)
    }
}

impl TypedBox {
    /// Number of axes.
    pub(super) fn dimensions(&self) -> usize {
        self.low.len()
    }

    /// Whether all values are at corners of cells, or all in cells; none for a mixture.
    pub(super) fn at_corners(&self) -> Option<bool> {
        match self.at_corners.as_slice() {
            [0, 0, 0] => Some(false),
            [1, 1, 1] => Some(true),
            _ => None,
        }
    }

    /// The cells, of which the values at corners have one more along each axis.
    pub(super) fn cells(&self) -> Option<IndexBox> {
        let [low, high, more] = [&self.low, &self.high, &self.at_corners];
        let three = |v: &Vec<i64>| <[i64; 3]>::try_from(v.as_slice()).ok();
        let (low, mut high, more) = (three(low)?, three(high)?, three(more)?);
        for (high, more) in high.iter_mut().zip(more) {
            *high = high.checked_sub(more)?;
        }
        IndexBox::new(low, high)
    }

    /// The box with `ghosts` more values on both sides of each axis.
    pub(super) fn grown(&self, ghosts: [u32; 3]) -> Option<Self> {
        let mut grown = self.clone();
        for (axis, ghosts) in ghosts.into_iter().enumerate() {
            let (low, high) = (grown.low.get_mut(axis)?, grown.high.get_mut(axis)?);
            *low = low.checked_sub(i64::from(ghosts))?;
            *high = high.checked_add(i64::from(ghosts))?;
        }
        Some(grown)
    }
}

impl std::fmt::Display for TypedBox {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let text = |v: &[i64]| v.iter().map(ToString::to_string).collect::<Vec<_>>().join(",");
        write!(f, "(({}) ({}) ({}))", text(&self.low), text(&self.high), text(&self.at_corners))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes() {
        let parse = |text: &str| Notation::new(text).typed_box();
        let cells = parse("((0,0,8) (31,31,31) (0,0,0))").unwrap();
        assert_eq!(cells.cells().unwrap().size(), [32, 32, 24]);
        assert_eq!(parse("( ( 0 , 0,8 )(31 ,31,31))"), Some(cells.clone()));
        assert_eq!(parse(&cells.to_string()), Some(cells.clone()));
        assert_eq!(cells.grown([1, 0, 2]).unwrap().to_string(), "((-1,0,6) (32,31,33) (0,0,0))");
        let corners = parse("((0,0,0) (4,4,4) (1,1,1))").unwrap();
        assert_eq!((corners.cells().unwrap().size(), corners.at_corners()), ([4; 3], Some(true)));
        assert_eq!(parse("((0) (4) (0))").unwrap().dimensions(), 1);
        for bad in ["", "((0,0,0) (1,1,1) (0,0,0)", "((0,0) (1,1,1))", "((0,0,x) (1,1,1))", "(0,0,0)"] {
            assert_eq!(parse(bad), None, "{bad}");
        }
        let beyond = parse("((0,0,0) (0,0,2147483647) (0,0,0))").unwrap();
        assert!(beyond.cells().is_none() && parse("((0,0,1) (0,0,0))").unwrap().cells().is_none());
    }

    #[test]
    fn number_formats() {
        let parse = |text: &str| Notation::new(text).real_format();
        let format = |sample, endian| Some(RealFormat { sample, endian });
        let double = "((8, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 3 2 1)))";
        assert_eq!(parse(double), format(SampleType::F64, Endian::Little));
        let float = "((8, (32 8 23 0 1 9 0 127)),(4, (1 2 3 4)))";
        assert_eq!(parse(float), format(SampleType::F32, Endian::Big));
        for (old, new) in [("52", "51"), ("(8 7", "(7 8"), ("(8, (8", "(7, (8"), (")))", "))")] {
            assert_eq!(parse(&double.replace(old, new)), None, "{new}");
        }
    }
}
