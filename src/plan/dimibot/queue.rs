//! A monotone priority queue (no key may be smaller than the last one taken): a radix heap (Ahuja and others 1990).
//! Items with equal keys leave last in, first out.

/// Items with a key, in buckets by the highest bit in which the key differs from the last one taken.
pub(super) struct RadixQueue<T> {
    last: u64,
    buckets: [Vec<(u64, T)>; 65],
    /// Bit b is set if bucket b is not empty (bucket 64 is left out: no key gets that large).
    full: u64,
}

impl<T> Default for RadixQueue<T> {
    fn default() -> Self {
        let buckets = std::array::from_fn(|_| Vec::new());
        RadixQueue { last: 0, buckets, full: 0 }
    }
}

impl<T> RadixQueue<T> {
    pub(super) fn clear(&mut self) {
        self.buckets.iter_mut().for_each(Vec::clear);
        (self.last, self.full) = (0, 0);
    }

    /// The key of the last item taken.
    pub(super) const fn last(&self) -> u64 {
        self.last
    }

    /// `key` must be at least the last one taken and less than 2^63.
    #[inline]
    pub(super) fn push(&mut self, key: u64, item: T) {
        let bucket = 64 - (key ^ self.last).leading_zeros();
        self.buckets[bucket as usize].push((key, item));
        self.full |= 1 << bucket;
    }

    #[inline]
    pub(super) fn pop(&mut self) -> Option<T> {
        if self.buckets[0].is_empty() {
            self.refill()?;
        }
        self.buckets[0].pop().map(|(_, item)| item)
    }

    fn refill(&mut self) -> Option<()> {
        self.full &= !1;
        if self.full == 0 {
            return None;
        }
        let bucket = self.full.trailing_zeros() as usize;
        self.full &= !(1 << bucket);
        let mut items = std::mem::take(&mut self.buckets[bucket]);
        self.last = items.iter().map(|(key, _)| *key).min()?;
        for (key, item) in items.drain(..) {
            self.push(key, item);
        }
        // Returns the allocation to the bucket.
        self.buckets[bucket] = items;
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix64;

    #[test]
    fn keys_leave_in_order() {
        let mut queue = RadixQueue::default();
        let mut random = SplitMix64::new(1);
        let mut key = move || random.next_u64() >> 50;
        let mut inside = std::collections::BinaryHeap::new();
        for _ in 0..5000 {
            if key() % 3 > 0 {
                let key = queue.last() + key();
                queue.push(key, key);
                inside.push(std::cmp::Reverse(key));
            } else {
                assert_eq!(queue.pop(), inside.pop().map(|r| r.0));
            }
        }
        while let Some(key) = queue.pop() {
            assert_eq!(Some(key), inside.pop().map(|r| r.0));
        }
        assert!(inside.is_empty());
    }
}
