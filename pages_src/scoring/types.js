/**
 * Messages between the page and Python, and types that the parts of the page share.
 *
 * @typedef {object} Model
 * @property {number | null} score given for the active factor, 0 to 100
 * @property {Scale | null} kind how it was given
 * @property {number | null} mean predicted for the active factor
 * @property {number | null} std standard deviation of that prediction, in points
 * @property {number | null} [product] predicted over all factors, 0 to 100
 * @property {string} label in words
 *
 * @typedef {import("../shared/types.js").Scale} Scale
 * @typedef {import("../shared/types.js").Said} Said
 * @typedef {"first" | "second" | "alike"} Verdict which of two models is preferred
 * @typedef {{ models: string[], said: Verdict | null }} Pair two models to compare, and what was said for the active factor
 *
 * @typedef {{ id: number, name: string, labels: number }} Factor known by its id, since other windows may rename it
 * @typedef {{ title: string, models: string[] }} Grid
 * @typedef {{ grids: number, rows: number, columns: number }} Layout
 * @typedef {{ name: string, label: string, says: string }} Way how to choose the models of grids, and what it is called
 * @typedef {{ of?: string, stage: string, done: number, total: number }} Progress
 * @typedef {{ labels: number, js: number }} Movement JS divergence between what was learned before and after an update, nats
 * @typedef {{ name: string, level: string, share: number }} Relevance
 *
 * @typedef {{ text: string, without: number, having: number }} Contrast a choice in words, and the mean predicted scores of models without and with it
 *
 * @typedef {object} State everything Python tells, whole each time it changes
 * @property {number} protocol
 * @property {string} title
 * @property {"grammar" | "species"} learns what is learned from the scores
 * @property {string} session
 * @property {number} revision number of the last event stored
 * @property {Factor[]} factors
 * @property {string} active
 * @property {"active" | "product"} view
 * @property {Layout} layout
 * @property {string} way
 * @property {Grid[]} grids
 * @property {string[]} line the first models that come next without a wait
 * @property {Record<string, Model>} models
 * @property {Pair[] | null} pairs that are shown; null where models are shown in grids
 * @property {string[]} recent scored models of the active factor, the latest first
 * @property {number} scored models that have a score
 * @property {number} compared comparisons, of all factors
 * @property {boolean} can_undo
 * @property {boolean} can_redo
 * @property {Movement[]} chart
 * @property {Relevance[]} relevance
 * @property {string[]} words What is liked and what is not, a sentence each.
 * @property {Contrast[]} contrasts choices on which the scores depend
 * @property {boolean} explained whether the scores have a pattern that replaces more than half of the original
 * @property {number | null} gain Nats that 16 more scores are expected to gain.
 * @property {string} turn Factor whose scores would tell most; empty if there is one factor only.
 * @property {Progress | null} updating
 * @property {boolean} fresh whether the predictions know all scores
 * @property {Way[]} ways
 * @property {string | null} message
 * @property {string[]} warnings about the models that are shown, all so far
 *
 * @typedef {import("../shared/types.js").Transport} Transport
 *
 * @typedef {object} Part a part of the page
 * @property {HTMLElement} element
 * @property {(state: State) => void} update draws what changed
 *
 * @typedef {object} Page what the parts share
 * @property {HTMLElement} root
 * @property {State} state
 * @property {import("../shared/channel.js").Channel} channel
 * @property {import("./outbox.js").Outbox} outbox
 * @property {import("./selection.js").Selection} selection
 * @property {import("./preferences.js").Preferences} preferences of this browser
 * @property {(command: string, parameters?: object) => Promise<any>} ask sends a command; a refusal is shown
 * @property {import("./pictures.js").Pictures} pictures
 * @property {(models: string[], score: number | null) => void} score on the scale in use
 * @property {(models: string[], said: Verdict | null) => void} compare two models
 * @property {import("../shared/ahead.js").Ahead} ahead what was set and is not confirmed: ``factor``, ``view``, ``pairs``
 * @property {() => void} pairwise pairs instead of grids, or grids again
 * @property {() => Factor} factor the one that is active as far as this page shows
 * @property {(text: string) => void} say a passing note, also for screen readers
 * @property {(error: unknown) => void} complain something that a person has to know
 * @property {(model: string) => void} look opens the 3D view
 */
export {};
