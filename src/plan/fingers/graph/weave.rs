//! Transposition of rows of bits into columns, 64 by 64 at a time.

use crate::plan::fingers::tables::ContactBits;

/// The bits of all triples whose second contact is `apart` after the first, as columns: one for each distance to the
/// third, and in it bit t for the first contact -t modulo the number of contacts. Only the pairs of first and second
/// contact that `counts` accepts are filled.
pub fn columns(
    bits: &ContactBits,
    contacts: usize,
    apart: usize,
    counts: impl Fn(usize, usize) -> bool,
    column: &mut [u64],
) {
    let width = contacts.div_ceil(64);
    let mut rows = vec![0; width * 64 * width];
    let (mut row, mut turned) = (vec![0; width], vec![0; width]);
    for at in 0..contacts {
        let first = (contacts - at) % contacts;
        let second = (first + apart) % contacts;
        if !counts(first, second) {
            continue;
        }
        let start = (first * contacts + second) * contacts;
        // Rotates the row, so that the third contact counts from the first one.
        turned.fill(0);
        bits.read_row(start + first, contacts - first, &mut turned);
        turned[(contacts - first).div_ceil(64)..].fill(0);
        bits.read_row(start, first, &mut row);
        append(&mut turned, contacts - first, &row, first);
        for (block, word) in turned.iter().enumerate() {
            rows[(block * width + at / 64) * 64 + at % 64] = *word;
        }
    }
    for (block, rows) in rows.chunks_exact_mut(64).enumerate() {
        let rows: &mut [u64; 64] = rows.try_into().expect("chunks have 64 words");
        transpose(rows);
        let (distances, word) = (block / width * 64, block % width);
        for (distance, bits) in (distances..contacts).zip(rows) {
            column[distance * width + word] = *bits;
        }
    }
}

/// Appends the first `count` bits of a row after the first `length` of another.
fn append(row: &mut [u64], length: usize, more: &[u64], count: usize) {
    let (word, shift) = (length / 64, length % 64);
    for (at, bits) in more.iter().enumerate().take(count.div_ceil(64)) {
        let left = count - at * 64;
        let bits = if left < 64 { bits & ((1 << left) - 1) } else { *bits };
        if word + at < row.len() {
            row[word + at] |= bits << shift;
        }
        if shift > 0 && word + at + 1 < row.len() {
            row[word + at + 1] |= bits >> (64 - shift);
        }
    }
}

/// Swaps bit j of word i with bit i of word j (Warren, Hacker's Delight, 7-3).
fn transpose(rows: &mut [u64; 64]) {
    let (mut half, mut mask) = (32, u64::from(u32::MAX));
    while half > 0 {
        for at in (0..64).filter(|at| at & half == 0) {
            let swapped = (rows[at] >> half ^ rows[at | half]) & mask;
            rows[at] ^= swapped << half;
            rows[at | half] ^= swapped;
        }
        half /= 2;
        mask ^= mask << half;
    }
}
