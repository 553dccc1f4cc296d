/** Text for the clipboard; where a browser keeps it from the page, the text is shown to be copied by hand. */

import { html } from "eulerdisk/html";

/**
 * Put a text into the clipboard, or show it.
 * @param {string} text
 * @returns {Promise<boolean>}  whether it is in the clipboard
 */
export async function copied(text) {
  try {
    // some browsers have none, and a frame of another page may not write to it
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return copiedFrom(shownText(text));
  }
}

/**
 * Copy what is selected in a dialog, which stays open where that is not possible.
 * @param {HTMLDialogElement} dialog
 */
function copiedFrom(dialog) {
  const done = document.execCommand("copy");
  if (done) dialog.close();
  return done;
}

/**
 * A dialog with a text that is selected. It goes when it is closed; the focus returns to where it was.
 * @param {string} text
 */
function shownText(text) {
  const area = html("textarea", {
    readonly: true,
    rows: "8",
    spellcheck: "false",
    "aria-label": "Text to copy",
  });
  area.value = text;
  const close = html("button", { type: "button", click: () => dialog.close() }, "Close");
  const words = html(
    "p",
    { id: "copy-words" },
    "This browser does not let the page copy. Copy this text yourself:",
  );
  const dialog = html("dialog", { class: "copy", "aria-labelledby": "copy-words" }, words, area, close);
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
  area.select();
  return dialog;
}
