//! The macro that declares bundles.

/// Declares one or more structures over a circuit `C`, and implements [`Bundle`](crate::Bundle) and
/// [`Family`](crate::Family) for them. The fields determine the ports. A structure may have constant parameters, such
/// as a number of lanes or the width of a word.
///
/// ```
/// raypath_ops::bundle! {
///     /// A point and its greatest allowed distance from the origin.
///     pub struct Reach<C> {
///         /// The point.
///         pub point: raypath_ops::Vec3<C>,
///         /// The greatest distance, squared.
///         pub limit: raypath_ops::Num<C>,
///     }
/// }
/// ```
#[macro_export]
macro_rules! bundle {
    () => {};
    (
        $(#[$attribute:meta])*
        pub struct $name:ident<C $(, const $n:ident: $kind:ident)*> {
            $($(#[$field_attribute:meta])* pub $field:ident: $type:ty),* $(,)?
        }
        $($others:tt)*
    ) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $name<C: $crate::Circuit $(, const $n: $kind)*> {
            $($(#[$field_attribute])* pub $field: $type,)*
        }

        impl<$(const $n: $kind),*> $crate::Family for $name<$crate::Binary32 $(, $n)*> {
            type Of<D: $crate::Circuit> = $name<D $(, $n)*>;

            #[inline(always)]
            fn gather<A: $crate::Circuit, B: $crate::Circuit, const K: usize>(
                items: [&$name<A $(, $n)*>; K],
                lanes: &impl $crate::Gather<A, B, K>,
            ) -> $name<B $(, $n)*> {
                type C = $crate::Binary32;
                $name {
                    $($field: <$type as $crate::Family>::gather(
                        $crate::array_of!(k => &items[k].$field),
                        lanes,
                    ),)*
                }
            }

            #[inline(always)]
            fn put<A: $crate::Circuit, B: $crate::Circuit>(
                value: &$name<A $(, $n)*>,
                target: &mut $name<B $(, $n)*>,
                lanes: &impl $crate::Put<A, B>,
            ) {
                type C = $crate::Binary32;
                $(<$type as $crate::Family>::put(&value.$field, &mut target.$field, lanes);)*
            }

            #[inline(always)]
            fn scatter<A: $crate::Circuit, B: $crate::Circuit, const K: usize>(
                value: $name<A $(, $n)*>,
                lanes: &impl $crate::Scatter<A, B, K>,
            ) -> [$name<B $(, $n)*>; K] {
                type C = $crate::Binary32;
                $(let $field = <$type as $crate::Family>::scatter(value.$field, lanes);)*
                $crate::array_of!(k => $name { $($field: $field[k],)* })
            }
        }

        impl<C: $crate::Circuit $(, const $n: $kind)*> $crate::Bundle<C> for $name<C $(, $n)*> {
            fn build<S: $crate::Source<C> + ?Sized>(path: &mut $crate::Path, source: &mut S) -> Self {
                $(
                    let entered = path.enter(stringify!($field));
                    let $field = <$type>::build(path, source);
                    path.leave(entered);
                )*
                Self { $($field),* }
            }
            fn each<S: $crate::Sink<C> + ?Sized>(&self, path: &mut $crate::Path, sink: &mut S) {
                $(
                    let entered = path.enter(stringify!($field));
                    self.$field.each(path, sink);
                    path.leave(entered);
                )*
            }
        }

        $crate::bundle! { $($others)* }
    };
}
