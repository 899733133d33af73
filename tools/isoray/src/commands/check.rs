//! `isoray check`.

use std::time::Instant;

use anyhow::Result;
use isoray_octree::{AnyVolume, is_series};

use crate::cli::CheckArgs;
use crate::output::to_stdout;
use crate::progress::Progress;
use crate::series;

pub(crate) fn run(args: &CheckArgs) -> Result<()> {
    if is_series(&args.file) {
        return series::check(&args.file);
    }
    let begin = Instant::now();
    let volume = AnyVolume::open(&args.file)?;
    let mut bar = Progress::new("checking");
    volume.verify_with_progress(&args.file, &mut |share| bar.update_share(share))?;
    drop(bar);
    let meta = volume.meta();
    to_stdout(|out| {
        writeln!(
            out,
            "{}: sound: {} {} samples, every checksum and node verified in {:.2} s",
            args.file.display(),
            meta.dims,
            volume.scalar(),
            begin.elapsed().as_secs_f64()
        )
    })
}
