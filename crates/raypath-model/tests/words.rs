//! The conversion of words to numbers in every circuit.

use raypath_float::Format;
use raypath_model::{BLOCK, Binary64, BlockSlice, BlockValue, Lanes, Packed, Simd, Soft, dispatch, levels};
use raypath_ops::{Binary32, Circuit, Gather, Num, Put, Word};

#[test]
fn every_word_is_exact() {
    let formats = [Format::BINARY32, Format::new(11, 17).expect("a format")];
    for value in 0..=u16::MAX {
        let (word, exact) = (u32::from(value), f64::from(value));
        assert_eq!(f32::from(Binary32.word::<16>(word).number()).to_bits(), f32::from(value).to_bits());
        assert_eq!(Binary64.word::<16>(word).number().value.0.to_bits(), exact.to_bits());
        for format in formats {
            let soft = Soft { format }.word::<16>(word).number().value.0;
            assert_eq!(format.to_f64(soft).to_bits(), exact.to_bits(), "{format}");
        }
    }
}

#[test]
fn every_word_is_exact_in_lanes() {
    for first in (0..=u16::MAX).step_by(BLOCK) {
        let words = Word::<Packed, 16>::new(Packed, BlockValue(std::array::from_fn(|i| u32::from(first) + i as u32)));
        let expected = std::array::from_fn::<_, BLOCK, _>(|i| f32::from(first + i as u16).to_bits());
        assert_eq!(words.number().value.0.map(f32::to_bits), expected);
        for level in levels() {
            let found = dispatch!(level, simd => numbers(simd, &words));
            assert_eq!(found.value.0.map(f32::to_bits), expected, "{level:?}");
        }
    }
}

#[inline(always)]
fn numbers<S: Simd>(simd: S, words: &Word<Packed, 16>) -> Num<Packed> {
    let (lanes, mut numbers) = (Lanes::new(simd), Packed.zero());
    for first in (0..BLOCK).step_by(Lanes::<S>::COUNT) {
        let part = BlockSlice { lanes, first };
        let word: Word<Lanes<S>, 16> = Gather::word(&part, [words]);
        Put::num(&part, &word.number(), &mut numbers);
    }
    numbers
}
