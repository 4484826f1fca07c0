//! Shorthands of this crate: refusals of one line, and reports as keys and values.

/// Ends a function with an error where something is as it must not be.
macro_rules! refuse_if {
    ($wrong:expr, $error:expr) => {
        if $wrong {
            return Err($error);
        }
    };
}

/// A [`ModelError`](crate::model::ModelError), with its sentence as `format!` takes it.
macro_rules! model_error {
    ($($sentence:tt)+) => {
        crate::model::ModelError::new(format!($($sentence)+))
    };
}

/// Keys and values that serialise in the order in which they stand here, each value by its own
/// type.
macro_rules! keys {
    ($($key:ident: $value:expr),+ $(,)?) => {{
        #[allow(non_camel_case_types, clippy::too_many_arguments, reason = "a value's type is called as its key is")]
        fn keys<$($key: serde::Serialize),+>($($key: $key),+) -> impl serde::Serialize {
            #[derive(serde::Serialize)]
            struct Keys<$($key),+> { $($key: $key),+ }
            Keys { $($key),+ }
        }
        keys($($value),+)
    }};
}
