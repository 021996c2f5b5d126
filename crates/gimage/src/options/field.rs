//! How options are declared: a struct per stage whose fields state their unit, default, range and effect.

use serde_json::{Value, json};

use super::Setting;
use crate::stage::assemble::backstops::Backstop;
use crate::stage::assemble::blends::Blend;
use crate::stage::assemble::limits::Limit;
use crate::stage::assemble::pins::{Pin, PinRule};
use crate::stage::blend::BlendWidth;
use crate::stage::import::Up;
use crate::stage::render::Subdivision;
use crate::stage::select::Pattern;
use crate::stage::stitch::Stitching;

/// An option whose value is one of a few words.
pub trait Choice: Copy + PartialEq + Sized + 'static {
    /// All values, by name.
    const ALL: &'static [(&'static str, Self)];

    /// The name of the value.
    fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, value)| *value == self).map_or("", |(name, _)| name)
    }
}

/// The type of an option.
pub(crate) trait Field {
    /// The settings of a field: one, but for types that stand for several. `about` has everything but the value.
    fn settings(&self, about: Setting) -> Vec<Setting>;
}

/// A setting with its value.
fn with(about: Setting, value: Value) -> Vec<Setting> {
    vec![Setting { value: Some(value), ..about }]
}

fn texts(list: &[impl ToString]) -> Value {
    json!(list.iter().map(ToString::to_string).collect::<Vec<_>>())
}

impl Field for f64 {
    fn settings(&self, about: Setting) -> Vec<Setting> {
        with(Setting { numbers: vec![*self], ..about }, json!(self))
    }
}

impl Field for Option<f64> {
    fn settings(&self, about: Setting) -> Vec<Setting> {
        with(Setting { numbers: self.iter().copied().collect(), ..about }, json!(self))
    }
}

impl Field for bool {
    fn settings(&self, about: Setting) -> Vec<Setting> {
        with(about, json!(self))
    }
}

impl<T: Choice> Field for T {
    fn settings(&self, about: Setting) -> Vec<Setting> {
        let choices = T::ALL.iter().map(|(name, _)| *name).collect();
        with(Setting { choices, ..about }, json!(self.name()))
    }
}

impl Field for Up {
    fn settings(&self, about: Setting) -> Vec<Setting> {
        with(about, json!(self.to_string()))
    }
}

impl Field for Stitching {
    fn settings(&self, about: Setting) -> Vec<Setting> {
        let numbers = if let Stitching::Within(distance) = self { vec![*distance] } else { Vec::new() };
        with(Setting { numbers, ..about }, json!(self.to_string()))
    }
}

impl Field for Vec<String> {
    fn settings(&self, about: Setting) -> Vec<Setting> {
        with(about, texts(self))
    }
}

impl Field for Vec<Pin> {
    fn settings(&self, about: Setting) -> Vec<Setting> {
        with(about, texts(self))
    }
}

impl Field for Option<PinRule> {
    fn settings(&self, about: Setting) -> Vec<Setting> {
        let choices = PinRule::ALL.iter().map(|(name, _)| *name).collect();
        // As for limits.
        vec![Setting { choices, value: self.map(|rule| json!(rule.name())), ..about }]
    }
}

impl Field for Vec<Pattern> {
    fn settings(&self, about: Setting) -> Vec<Setting> {
        // As for limits.
        if self.is_empty() { vec![about] } else { with(about, texts(self)) }
    }
}

impl Field for Vec<Limit> {
    fn settings(&self, about: Setting) -> Vec<Setting> {
        // The manifest of a bundle without limits is that of an older build.
        if self.is_empty() { vec![about] } else { with(about, texts(self)) }
    }
}

impl Field for Vec<Backstop> {
    fn settings(&self, about: Setting) -> Vec<Setting> {
        // As for limits.
        if self.is_empty() { vec![about] } else { with(about, texts(self)) }
    }
}

impl Field for Vec<Blend> {
    fn settings(&self, about: Setting) -> Vec<Setting> {
        // As for limits.
        if self.is_empty() { vec![about] } else { with(about, texts(self)) }
    }
}

impl Field for Option<BlendWidth> {
    fn settings(&self, about: Setting) -> Vec<Setting> {
        let numbers = if let Some(BlendWidth::Within(width)) = self { vec![*width] } else { Vec::new() };
        // As for limits.
        vec![Setting { numbers, value: self.map(|width| json!(width.to_string())), ..about }]
    }
}

impl Field for Option<Subdivision> {
    fn settings(&self, about: Setting) -> Vec<Setting> {
        let numbers = if let Some(Subdivision::Cells(cells)) = self { vec![*cells] } else { Vec::new() };
        // As for limits.
        vec![Setting { numbers, value: self.map(|cells| json!(cells.to_string())), ..about }]
    }
}

/// Declares the options of a stage: the struct, its default, `settings` and `check`.
///
/// A field is `name: type = default => "option" ["unit"] range;`. The comment above it is its rustdoc, and the effect in
/// the help of the command line and in docs/building.md. `(not recorded)` before the name of the option keeps it out of the
/// manifest. A field without `=>` is for callers of the library alone.
macro_rules! stage_options {
    (
        $(#[$attribute:meta])*
        pub struct $name:ident of $stage:literal {
            $(
                $(#[doc = $doc:literal])+
                pub $field:ident: $type:ty = $default:expr
                    $(=> $(($not:ident recorded))? $option:literal [$unit:literal] $range:expr)?;
            )*
        }
    ) => {
        $(#[$attribute])*
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name {
            $(
                $(#[doc = $doc])+
                #[doc = ""]
                $(#[doc = concat!("Unit: ", $unit, ". Range: `", stringify!($range), "`.")])?
                #[doc = concat!("Default: `", stringify!($default), "`.")]
                pub $field: $type,
            )*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        impl $name {
            /// The settings of the stage, with these values.
            pub fn settings(&self) -> Vec<$crate::options::Setting> {
                let mut out = Vec::new();
                $(
                    let help = concat!($($doc),+);
                    // A field without a setting has no help.
                    let _ = help;
                    $(
                        out.extend($crate::options::Field::settings(&self.$field, $crate::options::Setting {
                            stage: $stage,
                            name: $option,
                            unit: $unit,
                            range: $range,
                            choices: Vec::new(),
                            help: help.trim().to_owned(),
                            value: None,
                            numbers: Vec::new(),
                            recorded: matches!(stringify!($($not)?), ""),
                        }));
                    )?
                )*
                out
            }

            /// Checks every range.
            pub fn check(&self) -> $crate::error::Result<()> {
                $crate::options::check(&self.settings())
            }
        }
    };
}
pub(crate) use stage_options;
