/** @typedef {{ show: typeof import("../viewer/viewer.js").show }} Viewer */

/**
 * The code of the 3D view, which is loaded over the channel when it is first needed.
 * @param {import("../shared/channel.js").Channel} channel
 * @returns {() => Promise<Viewer>}
 */
export function viewerCode(channel) {
  /** @type {Promise<Viewer> | null} */
  let code = null;
  return async () => {
    code ??= load(channel);
    try {
      return await code;
    } catch (error) {
      code = null; // the next one tries again
      throw error;
    }
  };
}

/** @param {import("../shared/channel.js").Channel} channel */
async function load(channel) {
  const { buffers } = await channel.request("viewer");
  const url = URL.createObjectURL(new Blob(buffers, { type: "text/javascript" }));
  try {
    return await import(/* @vite-ignore */ url);
  } finally {
    URL.revokeObjectURL(url);
  }
}
