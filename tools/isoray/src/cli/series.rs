//! Flags that choose steps of a series.

use clap::Args;

/// Which steps of a series to render.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Series (.ovol.d)")]
pub(crate) struct StepArgs {
    /// Render this step, from 0
    #[arg(long, value_name = "N")]
    pub(crate) step: Option<usize>,
    /// Render the steps from A to B, B included, or every S-th of them, to numbered pictures: -o frame_%04d.png. What is
    /// left out is the first step, the last, and 1; all pictures have the camera, isovalue, transfer function and shading
    /// that the first one gets
    #[arg(long, value_name = "A:B[:S]", value_parser = parse_steps, conflicts_with = "step")]
    pub(crate) steps: Option<Steps>,
}

/// From one step to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Steps {
    pub(crate) first: usize,
    /// Included; the last there is if not given.
    pub(crate) last: Option<usize>,
    /// Not 0.
    pub(crate) stride: usize,
}

fn parse_steps(text: &str) -> Result<Steps, String> {
    let wrong = || format!("expected steps like 0:9 or 0:9:3, found '{text}'");
    let number = |part: &str| match part.trim() {
        "" => Ok(None),
        digits => digits.parse().map(Some).map_err(|_| wrong()),
    };
    let parts: Vec<&str> = text.split(':').collect();
    let (first, last, stride) = match parts[..] {
        [first, last] => (first, last, ""),
        [first, last, stride] => (first, last, stride),
        _ => return Err(wrong()),
    };
    let (first, last, stride) = (number(first)?.unwrap_or(0), number(last)?, number(stride)?.unwrap_or(1));
    if stride == 0 {
        return Err(format!(
            "expected every first step or fewer, found '{text}', with 0 from one to the next"
        ));
    }
    match last {
        Some(last) if last < first => Err(format!("expected two steps in ascending order, found '{text}'")),
        _ => Ok(Steps { first, last, stride }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_steps() {
        let steps = |first, last, stride| Ok(Steps { first, last, stride });
        assert_eq!(parse_steps("0:9"), steps(0, Some(9), 1));
        assert_eq!(parse_steps("3:3:2"), steps(3, Some(3), 2));
        assert_eq!(parse_steps("::2"), steps(0, None, 2));
        assert_eq!(parse_steps(":"), steps(0, None, 1));
        for wrong in ["", "3", "a:b", "-1:2", "1:2:3:4", "2:1", "0:9:0", "0:9:-1", "1.5:2"] {
            assert!(parse_steps(wrong).unwrap_err().contains(&format!("found '{wrong}'")), "{wrong}");
        }
    }
}
