//! Enums whose variants are words of the language: one list gives the variants, their spelling and their line of
//! help.

/// Declares an enum of words: `Variant = "word": "its meaning"`, the default first.
///
/// It has `ALL` and `CHOICES` (words with their help) in source order, `name`, `choice`, `find` and `default`; it is serialised
/// as its word.
macro_rules! words {
    ($(#[$meta:meta])* pub enum $name:ident { $($variant:ident = $word:literal: $doc:literal,)+ }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
        pub enum $name {
            $(#[doc = $doc] #[serde(rename = $word)] $variant,)+
        }

        impl Default for $name {
            fn default() -> $name {
                $name::ALL[0]
            }
        }

        impl $name {
            /// Every word, the default first.
            pub const ALL: &'static [$name] = &[$($name::$variant,)+];

            /// Every word with its meaning.
            pub const CHOICES: &'static [crate::device::WordChoice] =
                &[$($name::$variant.choice(),)+];

            /// The word in the language.
            pub const fn name(self) -> &'static str {
                self.choice().name
            }

            /// The word with its meaning, as printed by `tweeze devices`.
            pub const fn choice(self) -> crate::device::WordChoice {
                match self {
                    $($name::$variant => crate::device::WordChoice { name: $word, doc: $doc },)+
                }
            }

            /// The variant of a word.
            pub fn find(word: &str) -> Option<$name> {
                $name::ALL.iter().copied().find(|known| known.name() == word)
            }
        }
    };
}

pub(crate) use words;

#[cfg(test)]
mod tests {
    words! {
        /// Sizes.
        pub enum Size { Small = "small": "little", VeryLarge = "very_large": "much", }
    }

    #[test]
    fn a_word_is_its_variant_and_back() {
        assert_eq!(Size::default(), Size::Small);
        assert_eq!(Size::ALL.iter().map(|size| size.name()).collect::<Vec<_>>(), ["small", "very_large"]);
        assert_eq!(Size::find("very_large"), Some(Size::VeryLarge));
        assert_eq!(Size::find("large"), None);
        assert_eq!((Size::VeryLarge.choice().doc, Size::CHOICES[1].doc), ("much", "much"));
        assert_eq!(serde_json::to_string(&Size::VeryLarge).ok().as_deref(), Some("\"very_large\""));
        assert_eq!(serde_json::from_str::<Size>("\"small\"").ok(), Some(Size::Small));
    }
}
