/// Builds an array of at least one element from an expression of the index: `array_of!(i => a[i] + b[i])`. Unlike
/// [`std::array::from_fn`] it is always inlined, which operations over SIMD lanes require.
#[macro_export]
macro_rules! array_of {
    ($i:pat => $element:expr $(,)?) => {
        $crate::array_from(
            #[inline(always)]
            |$i| $element,
        )
    };
}

#[doc(hidden)]
#[inline(always)]
pub fn array_from<T: Copy, const N: usize>(make: impl Fn(usize) -> T) -> [T; N] {
    let mut elements = [make(0); N];
    // Short arrays without a loop, because the compiler would keep the operands in memory. The conditions are constants,
    // so that no code is generated for the others.
    if const { N <= 4 } {
        if const { N > 1 } {
            elements[1] = make(1);
        }
        if const { N > 2 } {
            elements[2] = make(2);
        }
        if const { N > 3 } {
            elements[3] = make(3);
        }
    } else {
        let mut i = 1;
        while i < N {
            elements[i] = make(i);
            i += 1;
        }
    }
    elements
}
