/// An array of things, at least one, each made from its number: `array_of!(i => a[i] + b[i])`. Unlike
/// [`std::array::from_fn`] it is always inlined, which operations need to run in SIMD lanes.
#[macro_export]
macro_rules! array_of {
    ($i:pat => $thing:expr $(,)?) => {
        $crate::array_from(
            #[inline(always)]
            |$i| $thing,
        )
    };
}

#[doc(hidden)]
#[inline(always)]
pub fn array_from<T: Copy, const N: usize>(make: impl Fn(usize) -> T) -> [T; N] {
    let mut things = [make(0); N];
    // Short ones without a loop: else compilers keep in memory what the array is made of.
    if N <= 4 {
        if N > 1 {
            things[1] = make(1);
        }
        if N > 2 {
            things[2] = make(2);
        }
        if N > 3 {
            things[3] = make(3);
        }
        return things;
    }
    for (i, thing) in things.iter_mut().enumerate().skip(1) {
        *thing = make(i);
    }
    things
}
