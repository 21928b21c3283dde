//! Parameters: what the command line, configuration files and documents need to know of each field of a configuration.

use super::declarations::Config;

/// A parameter of a configuration.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// The key in configuration files; `--` and this is the flag on the command line.
    pub name: &'static str,
    /// The accepted values, separated by `|`.
    pub values: &'static str,
    /// Whether the flag alone means `true`.
    pub is_switch: bool,
    /// The lines of the field's documentation.
    pub(super) lines: &'static [&'static str],
    pub(super) get: fn(&Config) -> String,
    pub(super) set: fn(&mut Config, &str) -> Result<(), String>,
}

/// Parameters that belong together.
#[derive(Debug, Clone, Copy)]
pub struct ParameterGroup {
    /// The heading of the group in help texts and documents.
    pub heading: &'static str,
    /// The parameters, in the order in which they are shown.
    pub parameters: &'static [Parameter],
}

impl Parameter {
    /// What the parameter means, in one paragraph without the final full stop.
    pub fn help(&self) -> String {
        let text = self.lines.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ");
        text.trim_end_matches('.').to_string()
    }

    /// The parameter's value in a configuration, as files and the command line write it.
    pub fn get(&self, config: &Config) -> String {
        (self.get)(config)
    }

    /// The default value, as files and the command line write it.
    pub fn default(&self) -> String {
        (self.get)(&Config::DEFAULT)
    }

    /// Sets the parameter in a configuration to a value that a user wrote.
    ///
    /// # Errors
    /// The text is not one of the parameter's values; the message quotes it and says what was expected.
    pub fn set(&self, config: &mut Config, text: &str) -> Result<(), String> {
        (self.set)(config, text)
    }
}

/// Declares a struct of parameters: for each field its name on the command line, its type and its default. The first
/// line says where the struct is in a [`Config`], the second is the heading of the group. `as` names the type that
/// says how the values of a field are written, if that is not the field's own type.
macro_rules! declare_parameters {
    (
        config$(.$path:ident)+;
        $heading:literal;
        $(#[$attribute:meta])*
        pub struct $struct:ident {
            $($(#[doc = $line:literal])+ $field:ident ($name:literal): $type:ty $(as $values:ty)? = $default:expr,)*
        }
        $($(#[$inner_attribute:meta])* pub $inner:ident: $inner_type:ty = $inner_default:expr,)*
    ) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub struct $struct {
            $($(#[doc = $line])+ pub $field: $type,)*
            $($(#[$inner_attribute])* pub $inner: $inner_type,)*
        }

        impl $struct {
            /// Every parameter at its default.
            pub const DEFAULT: Self = Self { $($field: $default,)* $($inner: $inner_default,)* };

            pub(super) const PARAMETERS: ParameterGroup = ParameterGroup {
                heading: $heading,
                parameters: &[$(Parameter {
                    name: $name,
                    values: <values!($type $(, $values)?) as Values<$type>>::TEXTS,
                    is_switch: <values!($type $(, $values)?) as Values<$type>>::IS_SWITCH,
                    lines: &[$($line),+],
                    get: |config| <values!($type $(, $values)?) as Values<$type>>::write(Self::of(config).$field),
                    set: |config, text| {
                        Self::of_mut(config).$field = <values!($type $(, $values)?) as Values<$type>>::parse(text)?;
                        Ok(())
                    },
                },)*],
            };

            const fn of(config: &Config) -> &Self {
                &config$(.$path)+
            }

            const fn of_mut(config: &mut Config) -> &mut Self {
                &mut config$(.$path)+
            }
        }

        impl Default for $struct {
            fn default() -> Self {
                Self::DEFAULT
            }
        }

        impl Config {
            $(
                #[doc = concat!("This configuration with another value of `", $name, "`.")]
                pub const fn $field(mut self, value: $type) -> Self {
                    $struct::of_mut(&mut self).$field = value;
                    self
                }
            )*
        }
    };
}
pub(super) use declare_parameters;

/// The type that says how a field's values are written.
macro_rules! values {
    ($type:ty) => {
        $type
    };
    ($type:ty, $values:ty) => {
        $values
    };
}
pub(super) use values;
