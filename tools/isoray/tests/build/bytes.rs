//! The bytes of a file depend on the samples alone.

use flate2::Compression;

use crate::inputs::{built, least, noise, nrrd};
use crate::sandbox::Sandbox;

/// Several strips, several layers of blocks, nothing a multiple of anything.
const SIZE: [usize; 3] = [37, 75, 29];

#[test]
fn bytes_depend_neither_on_threads_nor_on_memory_nor_on_coding() {
    let samples = SIZE.iter().product::<usize>();
    for (name, width) in [("uint8", 1), ("int8", 1), ("uint16", 2), ("int16", 2), ("float", 4)] {
        let sandbox = Sandbox::new();
        let bytes = noise(samples * width, 1);
        sandbox.write("a.nrrd", &nrrd(SIZE, name, &bytes, None));
        sandbox.write("b.nrrd", &nrrd(SIZE, name, &bytes, Some(Compression::fast())));
        let build = |file: &str, flags: &str| {
            let outcome = sandbox.line(&format!("build {file}.nrrd -o out.ovol {flags}"));
            assert_eq!(outcome.code, 0, "{outcome:?}");
            let bytes = sandbox.read("out.ovol");
            std::fs::remove_file(sandbox.path("out.ovol")).unwrap();
            bytes
        };
        let expected = build("a", "");
        for file in ["a", "b"] {
            for threads in [1, 2, 3, 7] {
                let least = least(&sandbox, &format!("build {file}.nrrd -o out.ovol --threads {threads}"));
                for memory in [least, least + 300_000, 1 << 30] {
                    let found = build(file, &format!("--threads {threads} --memory {memory}"));
                    let case = format!("{name} {file}, {threads} threads, {memory} bytes");
                    assert!(found == expected, "{case}: other bytes");
                }
            }
        }
        assert_eq!(sandbox.names(), ["a.nrrd", "b.nrrd"]);
    }
}

#[test]
fn the_least_limit_is_named_and_does() {
    let sandbox = Sandbox::new();
    let bytes = noise(SIZE.iter().product(), 2);
    sandbox.write("a.nrrd", &nrrd(SIZE, "uint8", &bytes, None));
    let line = "build a.nrrd -o out.ovol --threads 2";
    let least = least(&sandbox, line);
    let parts = ["a.nrrd", "37x75x29", &format!("at least {least} bytes"), "2 threads", "limit is"];
    sandbox.fails(1, &format!("{line} --memory {}", least - 1), &parts);
    let short = built(&sandbox, &format!("{line} --memory {least}"), "out.ovol");
    assert!(short == built(&sandbox, line, "out.ovol"));
}
