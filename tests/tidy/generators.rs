//! One random number generator: no other file mixes bits for one.

use super::{code, rust};

/// The only file with a generator.
const GENERATOR: &str = "src/random.rs";

/// Constants that only generators contain, in lower case and without `_`: SplitMix64, the constants of Knuth and of
/// Numerical Recipes, and xorshift. The golden ratio is not listed, because it also spreads the keys of hash tables.
const SIGNS: [&str; 4] = ["0xbf58476d1ce4e5b9", "6364136223846793005", "1664525", "<< 13;"];

/// Files that keep their own generator, and why.
const EXCEPTIONS: [(&str, &str); 4] = [
    (
        "src/check/microrobots/relays/tests/oracle.rs",
        "counts of tables of each kind, and how near mends are to the least",
    ),
    ("src/plan/electrode_array/joint/oracle.rs", "counts of solved, impossible and excluded instances in four tests"),
    ("src/plan/fingers/tip_motion/tests/mod.rs", "one course in which a finger must step aside, and counts of ways"),
    ("src/plan/microrobots/assembly/tests.rs", "every scattered bed must have a plan, which no rule promises"),
];

#[test]
fn random_numbers_have_one_generator() {
    let mut found: Vec<String> = Vec::new();
    for (path, text) in rust() {
        let text = code(&text).to_lowercase().replace('_', "");
        if SIGNS.iter().any(|sign| text.contains(sign)) {
            found.push(path);
        }
    }
    let mut allowed = EXCEPTIONS.map(|(path, _)| path).to_vec();
    allowed.push(GENERATOR);
    allowed.sort_unstable();
    found.sort_unstable();
    assert_eq!(found, allowed, "use `tweeze::random::SplitMix64`, or `tests/support/random.rs` in tests");
}
