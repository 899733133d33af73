//! The inputs of the fuzz target.

#[path = "../../../../fuzz/fuzz_targets/check.rs"]
mod check;

#[test]
fn what_is_promised_holds_of_the_corpus() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/corpus/cell");
    let mut tried = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let bytes = std::fs::read(entry.unwrap().path()).unwrap();
        check::check(&check::case(&bytes).expect("at least 60 bytes"));
        tried += 1;
    }
    assert!(tried >= 14, "only {tried} inputs");
}
