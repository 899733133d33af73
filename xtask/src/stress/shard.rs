//! A part of a run: its seeds, its progress, and the file by which it goes on after an interruption.

use std::fmt;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;
use std::path::PathBuf;
use std::str::FromStr;

use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::root;

/// How much is tried.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Args {
    /// Number of inputs, all shards together
    #[arg(long, default_value_t = 100_000_000)]
    pub(crate) count: u64,
    /// Chooses the inputs
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Only part I of N parts, the first being 1
    #[arg(long, value_name = "I/N", default_value = "1/1")]
    pub(crate) shard: Shard,
    /// Begin anew, whatever an earlier run has done
    #[arg(long)]
    pub(crate) fresh: bool,
}

/// Part `index` of `of`, counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shard {
    index: u64,
    of: u64,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match parts {
            Some((index, of)) if (1..=of).contains(&index) => Ok(Self { index: index - 1, of }),
            _ => Err(format!("{text:?}: expected I/N with 1 ≤ I ≤ N, like 2/8")),
        }
    }
}

/// What is counted.
pub(crate) trait Tally: Clone + Default + Send + Serialize + DeserializeOwned {
    fn merge(&mut self, other: Self);
}

/// Some of the inputs that came to something they must not, in a form that pastes into a test.
#[derive(Clone, Debug, Default, Serialize, serde::Deserialize)]
pub(crate) struct Offending(Vec<String>);

impl Offending {
    const KEPT: usize = 10;

    pub(crate) fn keep(&mut self, what: &str, input: &impl fmt::Debug) {
        if self.0.len() < Self::KEPT {
            self.0.push(format!("// {what}\n{input:?}"));
        }
    }

    pub(crate) fn merge(&mut self, other: Self) {
        self.0.extend(other.0);
        self.0.truncate(Self::KEPT);
    }
}

impl fmt::Display for Offending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.join("\n"))
    }
}

/// What came of a few inputs.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(crate) cases: u64,
    /// Those of which the reference cannot tell what is right; none where rules alone decide.
    pub(crate) doubtful: Option<u64>,
    pub(crate) failures: u64,
    pub(crate) offending: Offending,
}

/// The first `count` inputs, `at_a_time` by a thread, all at once and without a file.
pub(crate) fn few<T: Tally>(count: u64, at_a_time: u64, block: impl Fn(Range<u64>) -> T + Sync) -> T {
    let starts: Vec<u64> = (0..count).step_by(at_a_time as usize).collect();
    let tallies: Vec<T> =
        starts.into_par_iter().map(|start| block(start..count.min(start + at_a_time))).collect();
    let mut all = T::default();
    tallies.into_iter().for_each(|tally| all.merge(tally));
    all
}

/// What the file holds.
#[derive(serde::Serialize, serde::Deserialize)]
struct State<T> {
    /// Of the program that made it: another may find other things.
    program: u64,
    done: u64,
    tally: T,
}

/// Inputs that one thread tries at a time, and how many of those lie between two writes of the file.
const BLOCK: u64 = 1 << 14;
const BLOCKS: u64 = 256;

impl Args {
    /// The numbers of the shard's inputs.
    fn inputs(&self) -> Range<u64> {
        let part = |n: u64| (u128::from(self.count) * u128::from(n) / u128::from(self.shard.of)) as u64;
        part(self.shard.index)..part(self.shard.index + 1)
    }

    /// Runs `block`, which tries the inputs of a range, over the shard.
    pub(crate) fn run<T: Tally>(&self, name: &str, block: impl Fn(Range<u64>) -> T + Sync) -> Result<T> {
        let inputs = self.inputs();
        let file = self.file(name);
        let program = program()?;
        let mut state = State { program, done: 0, tally: T::default() };
        if !self.fresh
            && let Ok(text) = std::fs::read_to_string(&file)
            && let Ok(earlier) = serde_json::from_str::<State<T>>(&text)
            && earlier.program == program
        {
            println!("going on after {} inputs, by {}", earlier.done, file.display());
            state = earlier;
        }
        let bar = ProgressBar::new(inputs.end - inputs.start).with_style(ProgressStyle::with_template(
            "{bar:40} {human_pos}/{human_len} {per_sec}, {eta} left",
        )?);
        bar.set_position(state.done);
        let mut at = inputs.start + state.done;
        while at < inputs.end {
            let end = inputs.end.min(at + BLOCK * BLOCKS);
            let starts: Vec<u64> = (at..end).step_by(BLOCK as usize).collect();
            let tallies: Vec<T> = starts
                .into_par_iter()
                .map(|start| {
                    let range = start..end.min(start + BLOCK);
                    let length = range.end - range.start;
                    let tally = block(range);
                    bar.inc(length);
                    tally
                })
                .collect();
            tallies.into_iter().for_each(|tally| state.tally.merge(tally));
            at = end;
            state.done = at - inputs.start;
            save(&file, &state)?;
        }
        bar.finish_and_clear();
        Ok(state.tally)
    }

    fn file(&self, name: &str) -> PathBuf {
        let Shard { index, of } = self.shard;
        let name: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
        let file = format!("{name}-{}-seed-{}-{}-of-{of}.json", self.count, self.seed, index + 1);
        root().join("target/stress").join(file)
    }
}

fn save<T: Tally>(file: &PathBuf, state: &State<T>) -> Result<()> {
    let folder = file.parent().context("the file has a folder")?;
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let part = file.with_extension("part");
    std::fs::write(&part, serde_json::to_string(state)?)
        .and_then(|()| std::fs::rename(&part, file))
        .with_context(|| format!("cannot write {}", file.display()))
}

/// A number for this very program.
fn program() -> Result<u64> {
    let mut hasher = DefaultHasher::new();
    std::fs::read(std::env::current_exe()?)?.hash(&mut hasher);
    Ok(hasher.finish())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_cover_all_inputs_once() {
        let args = |index, of| Args { count: 1003, seed: 0, shard: Shard { index, of }, fresh: false };
        let mut next = 0;
        for index in 0..7 {
            let inputs = args(index, 7).inputs();
            assert_eq!(inputs.start, next);
            next = inputs.end;
        }
        assert_eq!(next, 1003);
    }

    #[test]
    fn few_inputs_are_all_tried() {
        #[derive(Clone, Default, Serialize, serde::Deserialize)]
        struct Sum(u64);
        impl Tally for Sum {
            fn merge(&mut self, other: Self) {
                self.0 += other.0;
            }
        }
        assert_eq!(few(1003, 16, |inputs| Sum(inputs.sum())).0, 1003 * 1002 / 2);
    }

    #[test]
    fn shards_are_counted_from_one() {
        assert_eq!("2/8".parse(), Ok(Shard { index: 1, of: 8 }));
        for text in ["0/8", "9/8", "1", "a/2", "1/0"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
