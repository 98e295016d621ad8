const DEFAULTS = { bars: true, advance: true, preview: true, scale: "score" };

/** @typedef {typeof DEFAULTS} Preferences */

/**
 * What a person likes in this browser; where it cannot be kept (a sandboxed notebook), it lasts as long as the page.
 * @returns {Preferences}
 */
export function loadPreferences() {
  return new Proxy(
    { ...DEFAULTS, ...stored() },
    {
      set(all, name, value) {
        Reflect.set(all, name, value);
        try {
          localStorage.setItem("grammarlab", JSON.stringify(all));
        } catch {
          // not kept
        }
        return true;
      },
    },
  );
}

function stored() {
  try {
    return JSON.parse(localStorage.getItem("grammarlab") ?? "{}");
  } catch {
    return {};
  }
}
