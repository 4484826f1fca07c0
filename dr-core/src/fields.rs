//! The fields of a value as 32-bit words in a fixed order: one visitor for the checksum, which
//! protects memory, and for the digest, which compares runs.
//!
//! Structs derive it, so that no field can be left out; for enums [`fields`] names the variants,
//! and one left out does not compile.

/// Visitor that is given the words of a value, one after the other.
pub(crate) trait FieldVisitor {
    /// Takes one word.
    fn word(&mut self, word: u32);
}

/// A value that consists of words.
pub(crate) trait Fields {
    /// Passes all words to a visitor, in a fixed order.
    fn visit(&self, visitor: &mut impl FieldVisitor);

    /// Passes the words of a list of values.
    fn visit_each(all: &[Self], visitor: &mut impl FieldVisitor)
    where
        Self: Sized,
    {
        all.iter().for_each(|one| one.visit(visitor));
    }
}

/// `#[derive(Fields!)]`: the fields of a struct, in the order in which they are declared.
macro_rules! Fields {
    ($(#[$of_struct:meta])* $shown:vis struct $type:ident $(<const $size:ident: usize>)? {
        $($(#[$of_field:meta])* $open:vis $field:ident: $inside:ty),* $(,)?
    }) => {
        impl$(<const $size: usize>)? $crate::fields::Fields for $type$(<$size>)? {
            fn visit(&self, visitor: &mut impl $crate::fields::FieldVisitor) {
                $($crate::fields::Fields::visit(&self.$field, visitor);)*
            }
        }
    };
}

/// Implements [`Fields`] for an enum: each variant with its word, and what is inside.
macro_rules! fields {
    (enum $type:ty { $($word:literal $variant:ident $(($inside:ident))? $({ $($field:ident),* })?),* $(,)? }) => {
        impl $crate::fields::Fields for $type {
            fn visit(&self, visitor: &mut impl $crate::fields::FieldVisitor) {
                match self {
                    $(Self::$variant $(($inside))? $({ $($field),* })? => {
                        visitor.word($word);
                        $($crate::fields::Fields::visit($inside, visitor);)?
                        $($($crate::fields::Fields::visit($field, visitor);)*)?
                    })*
                }
            }
        }
    };
}
pub(crate) use fields;

impl Fields for f32 {
    #[inline]
    fn visit(&self, visitor: &mut impl FieldVisitor) {
        visitor.word(self.to_bits());
    }

    #[inline(never)] // one loop for all tables
    fn visit_each(all: &[Self], visitor: &mut impl FieldVisitor) {
        all.iter().for_each(|number| number.visit(visitor));
    }
}

/// Numbers that fit a word.
macro_rules! words {
    ($($type:ty),*) => {
        $(impl Fields for $type {
            #[inline]
            fn visit(&self, visitor: &mut impl FieldVisitor) {
                visitor.word(*self as u32);
            }
        })*
    };
}
words!(u32, u16, u8, usize, i32, bool);

impl<T: Fields, const N: usize> Fields for [T; N] {
    #[inline]
    fn visit(&self, visitor: &mut impl FieldVisitor) {
        T::visit_each(self, visitor);
    }
}

impl<T: Fields> Fields for Option<T> {
    #[inline]
    fn visit(&self, visitor: &mut impl FieldVisitor) {
        self.is_some().visit(visitor);
        if let Some(inside) = self {
            inside.visit(visitor);
        }
    }
}

impl<T: Fields> Fields for &T {
    #[inline]
    fn visit(&self, visitor: &mut impl FieldVisitor) {
        (*self).visit(visitor);
    }
}

impl<A: Fields, B: Fields> Fields for (A, B) {
    #[inline]
    fn visit(&self, visitor: &mut impl FieldVisitor) {
        let (a, b) = self;
        a.visit(visitor);
        b.visit(visitor);
    }
}
