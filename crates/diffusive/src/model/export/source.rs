//! Constants for a program on a board, in f32, as C or Rust source text.
//!
//! ```text
//! y = OFFSET_C + Σ_k R_K_PER_W[k] · x[k] + FEED_THROUGH_K_PER_W · u
//! x[k] += GAIN[k] · (u − x[k])     each sample period
//! ```
//!
//! The gains g_k = 1 − e^(−ξ_k Ts) are worked out in f64 from the rounded rates, as the controller
//! does it: they hold for the sample period in the table only. In f32 the sum of a slow pole must
//! be compensated (Kahan), or it stalls before its goal.

use dr_core::model::mesh;

use crate::model::ModelError;
use crate::model::pair_class::PairClass;

/// Language of the source text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    /// C.
    C,
    /// Rust.
    Rust,
}

/// The source text of one pair's tables.
///
/// # Errors
/// If a number does not fit f32, or two rates are the same there; in a wind that has no symbol of
/// its own.
pub fn source(part: &PairClass, language: Language) -> Result<String, ModelError> {
    part.refuse_wind()?;
    let period = single("sample_period_s", part.model.sample_period_s)?;
    let rates = singles("mesh_rad_s", &part.pair.mesh_rad_s)?;
    refuse_if!(
        rates.windows(2).any(|two| two[0] >= two[1]),
        model_error!("two rates of the mesh are the same in f32: reduce the model first")
    );
    let gain = rates.iter().map(|rate| mesh::gain(f64::from(*rate), f64::from(period)) as f32).collect();
    let r = singles("r_k_per_w", &part.class.r_k_per_w)?;
    let feed_through = single("feed_through_k_per_w", part.class.feed_through_k_per_w)?;
    let offset = single("offset_c", part.offset_c())?;
    let (order, dead) = (rates.len(), part.pair.dead_time_samples);
    let constants = [
        ("order", "Number of relaxations.", Constant::Count(order)),
        ("dead_time_samples", "Whole sample periods by which the output is late.", Constant::Count(dead)),
        ("sample_period_s", "Sample period for which the gains hold, s.", Constant::Number(period)),
        ("feed_through_k_per_w", "What the output follows at once, K/W.", Constant::Number(feed_through)),
        ("offset_c", "Output without heating, degrees Celsius.", Constant::Number(offset)),
        ("mesh_rad_s", "Relaxation rates, rad/s.", Constant::Numbers(rates)),
        ("gain", "Gains, for that sample period only.", Constant::Numbers(gain)),
        ("r_k_per_w", "Thermal resistances, K/W.", Constant::Numbers(r)),
    ];
    let (mut text, start, end) = match language {
        Language::Rust => (String::new(), "\n", ""),
        Language::C => ("/*\n".to_owned(), " */\n#ifndef ANEMO_MODEL_H\n#define ANEMO_MODEL_H\n\n", "\n#endif\n"),
    };
    for line in about(part) {
        let margin = if language == Language::Rust { "//" } else { " *" };
        text.push_str(format!("{margin} {}", plain(&line)).trim_end());
        text.push('\n');
    }
    text.push_str(start);
    for (name, meaning, constant) in constants {
        text.push_str(&constant.declared(name, meaning, language));
    }
    text.push_str(end);
    Ok(text)
}

/// The lines above the constants.
fn about(part: &PairClass) -> Vec<String> {
    let mut about = vec![
        format!("{} -> {}, class {}: diffusive model by anemo.", part.pair.input, part.pair.output, part.label),
        String::new(),
        "Each sample period, with the power u held (add with compensation: slow poles stall in plain f32):".to_owned(),
        "  x[k] += gain[k] * (u - x[k]),   y = offset_c + sum r_k_per_w[k] * x[k] + feed_through_k_per_w * u"
            .to_owned(),
        "u is that of dead_time_samples earlier.".to_owned(),
    ];
    about.extend(part.warning().map(|warning| format!("Warning: {warning}")));
    about
}

/// A value of the source text.
enum Constant {
    Count(usize),
    Number(f32),
    /// One number a relaxation.
    Numbers(Vec<f32>),
}

impl Constant {
    fn declared(&self, name: &str, meaning: &str, language: Language) -> String {
        let upper = name.to_uppercase();
        match (language, self) {
            (Language::Rust, Self::Count(value)) => format!("/// {meaning}\npub const {upper}: usize = {value};\n"),
            (Language::Rust, Self::Number(value)) => format!("/// {meaning}\npub const {upper}: f32 = {value:?};\n"),
            (Language::Rust, Self::Numbers(values)) => {
                format!("/// {meaning}\npub const {upper}: [f32; ORDER] = {values:?};\n")
            }
            (Language::C, Self::Count(value)) => format!("/* {meaning} */\n#define MODEL_{upper} {value}\n"),
            (Language::C, Self::Number(value)) => {
                format!("/* {meaning} */\nstatic const float model_{name} = {value:?}f;\n")
            }
            (Language::C, Self::Numbers(values)) => {
                let list: Vec<String> = values.iter().map(|value| format!("{value:?}f")).collect();
                format!("/* {meaning} */\nstatic const float model_{name}[MODEL_ORDER] = {{{}}};\n", list.join(", "))
            }
        }
    }
}

fn single(key: &str, value: f64) -> Result<f32, ModelError> {
    let rounded = value as f32;
    // A value that is not zero must not become zero: a rate or gain of zero is another model.
    if rounded.is_finite() && (rounded != 0.0 || value == 0.0) {
        return Ok(rounded);
    }
    Err(model_error!("`{key}`: {value:?} does not fit the range of f32, in which these tables are"))
}

fn singles(key: &str, values: &[f64]) -> Result<Vec<f32>, ModelError> {
    values.iter().map(|value| single(key, *value)).collect()
}

/// Text that cannot end a comment.
fn plain(text: &str) -> String {
    text.replace("*/", "* /").replace(['\n', '\r'], " ")
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;
    use crate::model::testing;

    fn text(language: Language) -> String {
        let model = testing::model(&[1e-5, 0.1, 25.0], &[1e-7, -30.25, 4e6]);
        source(&PairClass::find(&model, None, None).unwrap(), language).unwrap()
    }

    /// Tells whether a compiler takes the text; `None`, with a message, where there is no such
    /// compiler.
    fn compiles(compiler: &str, arguments: &[&str], file: &str, text: &str) -> Option<bool> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(file), text).unwrap();
        match Command::new(compiler).args(arguments).arg(file).current_dir(folder.path()).output() {
            Ok(output) => {
                print!("{}", String::from_utf8_lossy(&output.stderr));
                Some(output.status.success())
            }
            Err(error) => {
                println!("skipped: {compiler} cannot be run ({error})");
                None
            }
        }
    }

    #[test]
    fn the_rust_text_compiles_and_holds_the_gains_of_the_core() {
        let text = text(Language::Rust);
        let core = dr_core::model::Relaxations::new(&[1e-5, 0.1, 25.0], 0.1).unwrap();
        assert!(text.contains(&format!("pub const GAIN: [f32; ORDER] = {:?};", core.gain())), "{text}");
        let arguments = ["--edition", "2024", "--crate-type", "lib", "-D", "warnings", "--emit", "metadata"];
        assert_ne!(compiles("rustc", &arguments, "model.rs", &text), Some(false), "{text}");
        // A text that is wrong is found out.
        let broken = text.replace("ORDER: usize = 3", "ORDER: usize = 4");
        assert_ne!(compiles("rustc", &arguments, "model.rs", &broken), Some(true));
    }

    #[test]
    fn the_c_text_compiles() {
        let text = text(Language::C);
        // It is compiled as it is used: included, warnings being errors.
        let arguments =
            ["-std=c99", "-Wall", "-Werror", "-pedantic", "-fsyntax-only", "-include", "model.h", "-x", "c"];
        assert_ne!(compiles("cc", &arguments, "model.h", &text), Some(false), "{text}");
        assert_ne!(compiles("cc", &arguments, "model.h", &text.replace("ORDER 3", "ORDER 2")), Some(true));
    }

    #[test]
    fn what_does_not_fit_f32_is_refused() {
        let refused = |mesh: &[f64], r: &[f64]| {
            let model = testing::model(mesh, r);
            source(&PairClass::find(&model, None, None).unwrap(), Language::C).unwrap_err()
        };
        assert!(
            refused(&[0.1, 1.0], &[1e40, 1.0]).to_string().contains("`r_k_per_w`: 1e40 does not fit the range of f32")
        );
        assert!(refused(&[0.1, 0.1 + 1e-12], &[1.0, 1.0]).to_string().contains("the same in f32"));
    }
}
