/// Implements `Display` and `FromStr` for an enumeration with named variants, with the error of an unknown name.
#[doc(hidden)]
#[macro_export]
macro_rules! names {
    ($type:ident { $($variant:ident = $name:expr),* }, $(#[$doc:meta])* $error:ident, $message:literal) => {
        impl $type {
            /// Its name.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }

        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }

        impl std::str::FromStr for $type {
            type Err = $error;
            fn from_str(name: &str) -> Result<Self, $error> {
                match name {
                    $(name if name == $name => Ok(Self::$variant),)*
                    _ => Err($error(name.to_string())),
                }
            }
        }

        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
        #[error($message)]
        pub struct $error(String);
    };
}
