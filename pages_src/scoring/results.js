import { element } from "../shared/element.js";
import { makeBusy } from "./busy.js";
import { counted } from "./known.js";
import { choice, menu, textButton } from "../shared/menu.js";

/** @typedef {import("./types.js").Page} Page */

const FORMATS = {
  csv: "opens in any spreadsheet",
  jsonl: "one JSON object per line",
  parquet: "for Arrow, pandas and Polars",
};
const SHEET = 16;

/**
 * What a session is for: a grammar, pictures of its samples, and the scores as a file.
 * @param {Page} page
 */
export function makeResults(page) {
  const { learns } = page.state;
  const learn = textButton(`Learn ${learns}`, () => busyWith(learn, learnGrammar), {
    title: `Write a ${learns} whose samples follow your scores`,
  });
  const sheet = textButton("Check sheet", () => busyWith(sheet, drawSheet), {
    title: `Pictures of ${SHEET} samples of the learned ${learns}`,
  });
  const picker = element("input", {
    type: "file",
    accept: ".csv,.tsv,.jsonl,.parquet",
    hidden: true,
    onchange: importScores,
  });
  const give = menu(
    textButton("Export scores", () => {}, { class: "gl-button gl-chooser" }),
    "Scores as a file",
    buildFormats,
  );
  const take = textButton("Import scores", () => picker.click(), {
    title: "A file that was exported here, or written by grammarlab label",
  });
  const busy = makeBusy("Result", () => void page.ask("cancel", { of: "result" }));
  const outcome = element("div", { class: "gl-outcome", role: "status" });
  const buttons = element("div", { class: "gl-pairs" }, learn, sheet, give, take);
  const section = element(
    "section",
    { class: "gl-card", "aria-label": "Result" },
    element("h2", {}, "Result"),
    buttons,
    busy.element,
    outcome,
    picker,
  );

  async function learnGrammar() {
    const { result } = await page.channel.request("learn");
    const { file, rules_before: before, rules_after: after, text } = result;
    const told = `${file}: ${before} branches of rules became ${after}.`;
    const link = saveLink(file, [text], "text/plain");
    outcome.replaceChildren(element("p", {}, told), ...hints(result.notes), link);
    reveal(outcome);
    link.click();
  }

  async function drawSheet() {
    const { result, buffers } = await page.channel.request("sheet", { num: SHEET });
    const link = saveLink(result.file, buffers, "image/png");
    const picture = element("img", { src: link.href, alt: `${SHEET} samples of the learned ${learns}` });
    // Its height is known once it is there.
    picture.addEventListener("load", () => reveal(outcome));
    outcome.replaceChildren(picture, link);
  }

  /** @param {() => void} close */
  function buildFormats(close) {
    return Object.entries(FORMATS).map(([format, says]) =>
      choice(format.toUpperCase(), says, () => {
        close();
        void exportScores(format);
      }),
    );
  }

  /** @param {string} format */
  async function exportScores(format) {
    try {
      const { result, buffers } = await page.channel.request("export", { format });
      const link = saveLink(result.file, buffers, "application/octet-stream");
      section.append(link); // VS Code saves only what is clicked within its document
      link.click();
      link.remove();
    } catch (error) {
      page.complain(error);
    }
  }

  async function importScores() {
    const [file] = picker.files ?? [];
    picker.value = "";
    if (!file) return;
    try {
      const format = file.name.split(".").pop()?.toLowerCase();
      const { result } = await page.channel.request("import", { format }, [await file.arrayBuffer()]);
      page.say(`${counted(result.added, "score") || "no scores"} imported`);
      outcome.replaceChildren(...hints(result.notes));
    } catch (error) {
      page.complain(error);
    }
  }

  /** What else is to be known about a result. @param {string[]} notes */
  const hints = (notes = []) => notes.map((note) => element("p", { class: "gl-hint" }, `Note: ${note}`));

  /** @param {HTMLButtonElement} button @param {() => Promise<void>} work */
  async function busyWith(button, work) {
    if (!isBusy()) busy.progress({ stage: "starting", done: 0, total: 0 });
    reveal(busy.element);
    button.disabled = true;
    button.classList.add("gl-working");
    try {
      await work();
    } catch (error) {
      page.complain(error);
    } finally {
      button.disabled = false;
      button.classList.remove("gl-working");
      if (!isBusy()) busy.progress(null);
    }
  }

  /** Below the buttons there is often no room left. @param {HTMLElement} part */
  const reveal = (part) => part.scrollIntoView({ block: "center" });
  /** Whether this window waits for a grammar or a sheet; their bar is one. */
  const isBusy = () => learn.disabled || sheet.disabled;

  /** @type {string[]} */
  const urls = [];

  /** @param {string} file @param {BlobPart[]} content @param {string} type */
  function saveLink(file, content, type) {
    const href = URL.createObjectURL(new Blob(content, { type }));
    urls.push(href);
    return element("a", { href, download: file }, `Save ${file}`);
  }

  return {
    element: section,
    /** Of what any window asked for; said where it was asked. @param {import("./types.js").Progress} now */
    progress(now) {
      if (isBusy()) busy.progress(now);
    },
    close: () => urls.forEach((url) => URL.revokeObjectURL(url)),
  };
}
