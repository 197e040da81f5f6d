//! LZF, the compression of PCD.

/// Largest factor of the format: 264 bytes from 3.
const GAIN: usize = 88;

/// The `size` bytes that were packed; `None` where the stream is corrupt or gives another number of them.
///
/// A control byte c < 32 is followed by c + 1 bytes as they are; any other says "repeat": its upper three bits are the length less
/// two, 7 meaning that a byte with the rest of the length follows; its lower five and the byte after are how far back, less one.
pub(super) fn unpacked(packed: &[u8], size: usize) -> Option<Vec<u8>> {
    if size / GAIN > packed.len() {
        return None; // before memory is asked for
    }
    let mut out = Vec::with_capacity(size);
    let mut rest = packed.iter();
    while let Some(control) = rest.next() {
        let control = usize::from(*control);
        if control < 32 {
            let (literal, after) = rest.as_slice().split_at_checked(control + 1)?;
            out.extend_from_slice(literal);
            rest = after.iter();
        } else {
            let more = if control >> 5 == 7 { usize::from(*rest.next()?) } else { 0 };
            let length = (control >> 5) + more + 2;
            let distance = ((control & 31) << 8 | usize::from(*rest.next()?)) + 1;
            let start = out.len().checked_sub(distance)?;
            for i in start..start + length {
                out.push(out[i]);
            }
        }
        if out.len() > size {
            return None;
        }
    }
    (out.len() == size).then_some(out)
}

#[cfg(test)]
mod tests {
    use super::unpacked;

    #[test]
    fn literals_and_overlapping_repeats_are_unpacked() {
        // "ab", then 9 + 2 bytes from 2 back: 7 in the control byte and 2 more.
        let packed = [1, b'a', b'b', 0b1110_0000, 2, 1];
        assert_eq!(unpacked(&packed, 13).as_deref(), Some(&b"ababababababa"[..]));
        assert_eq!(unpacked(&[], 0), Some(vec![]));
    }

    #[test]
    fn a_corrupt_stream_is_refused() {
        for packed in [&[5, b'a'][..], &[0b0010_0000, 0], &[1, b'a', b'b', 0b1110_0000], &[0, b'a', 0xff]] {
            assert_eq!(unpacked(packed, 13), None, "{packed:?}");
        }
        assert_eq!(unpacked(&[0, b'a'], 2), None);
        assert_eq!(unpacked(&[0, b'a'], usize::MAX), None);
    }
}
