//! Writes the adaptive mesh that programs are compared on as an AMReX plotfile: `cargo run --release -p isoray-benches --example clumps -- FOLDER`.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use isoray_amr::{Patch, Patches};
use isoray_benches::clumps::clumps_4;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args_os().nth(1).ok_or("expected the folder to be written")?);
    if folder.exists() {
        return Err(format!("{}: expected a folder that is not there yet", folder.display()).into());
    }
    let mesh = clumps_4();
    // Complete or absent.
    let unfinished = folder.with_extension("unfinished");
    for level in 0..=mesh.ratios.len() as u32 {
        let patches: Vec<&Patch> = mesh.patches.iter().filter(|patch| patch.level == level).collect();
        boxes(&unfinished.join(format!("Level_{level}")), &patches)?;
    }
    fs::write(unfinished.join("Header"), header(&mesh)?)?;
    fs::rename(&unfinished, &folder)?;
    println!("{}: {} boxes in {} levels", folder.display(), mesh.patches.len(), mesh.ratios.len() + 1);
    Ok(())
}

/// Of the domain from 0 to 1.
fn header(mesh: &Patches) -> Result<String, std::fmt::Error> {
    let (levels, base) = (mesh.ratios.len() as u32 + 1, mesh.domain.1[0]);
    let mut text = format!("HyperCLaw-V1.1\n1\ndensity\n3\n0\n{}\n0 0 0\n1 1 1\n", levels - 1);
    let all = |of: &dyn Fn(u32) -> String| (0..levels).map(of).collect::<Vec<_>>().join(" ");
    writeln!(text, "{}", vec!["2"; levels as usize - 1].join(" "))?;
    writeln!(text, "{}", all(&|level| corners([0; 3], [base << level; 3])))?;
    writeln!(text, "{}", all(&|_| "0".to_owned()))?;
    for level in 0..levels {
        let edge = 1.0 / f64::from(base << level);
        writeln!(text, "{edge} {edge} {edge}")?;
    }
    writeln!(text, "0\n0")?;
    for level in 0..levels {
        let patches = mesh.patches.iter().filter(|patch| patch.level == level);
        writeln!(text, "{level} {} 0\n0", patches.clone().count())?;
        let edge = 1.0 / f64::from(base << level);
        for patch in patches {
            for (low, cells) in patch.low.iter().zip(patch.cells) {
                let low = f64::from(*low);
                writeln!(text, "{} {}", low * edge, (low + f64::from(cells)) * edge)?;
            }
        }
        writeln!(text, "Level_{level}/Cell")?;
    }
    Ok(text)
}

/// A level's boxes, all in one file, and what says where.
fn boxes(folder: &Path, patches: &[&Patch]) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    let mut text = format!("1\n1\n1\n0\n({} 0\n", patches.len());
    let (mut places, mut least, mut most) = (String::new(), String::new(), String::new());
    let mut file = Vec::new();
    for patch in patches {
        let place = corners(patch.low, patch.cells);
        writeln!(text, "{place}")?;
        writeln!(places, "FabOnDisk: Cell_D_00000 {}", file.len())?;
        let [low, high] = patch
            .values
            .iter()
            .fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], &v| [low.min(v), high.max(v)]);
        writeln!(least, "{low},")?;
        writeln!(most, "{high},")?;
        writeln!(file, "FAB ((8, (32 8 23 0 1 9 0 127)),(4, (4 3 2 1))){place} 1")?;
        patch.values.iter().for_each(|v| file.extend(v.to_le_bytes()));
    }
    writeln!(text, ")\n{}\n{places}", patches.len())?;
    writeln!(text, "{},1\n{least}\n{},1\n{most}", patches.len(), patches.len())?;
    fs::write(folder.join("Cell_D_00000"), file)?;
    Ok(fs::write(folder.join("Cell_H"), text)?)
}

/// The lowest and the highest cell, and that values are of cells.
fn corners<L: Copy + Into<i64>>(low: [L; 3], cells: [u32; 3]) -> String {
    let low = low.map(Into::into);
    let high: [i64; 3] = std::array::from_fn(|a| low[a] + i64::from(cells[a]) - 1);
    let vector = |v: [i64; 3]| format!("({},{},{})", v[0], v[1], v[2]);
    format!("({} {} (0,0,0))", vector(low), vector(high))
}
