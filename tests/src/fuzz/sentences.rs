//! Form of a refusal: one sentence, without what could disturb a terminal.

/// A refusal is one sentence that can be shown as it is.
pub(super) fn said(sentence: &str) {
    assert!(!sentence.trim().is_empty(), "a refusal without a word");
    assert!(!sentence.contains(char::is_control), "more than one line: {sentence:?}");
}

/// A refusal of a file names the file.
pub(super) fn said_of(name: &str, sentence: &str) {
    said(sentence);
    assert!(sentence.contains(name), "of which file? {sentence:?}");
}
