/** The pictures that leaves show parts of, asked for once. */
export class Pictures {
  /** @type {(ImageBitmap | undefined)[]} */
  images = [];
  #channel;
  #arrived;
  #asked = 0;

  /**
   * @param {import("../shared/channel.js").Channel} channel
   * @param {() => void} arrived
   */
  constructor(channel, arrived) {
    this.#channel = channel;
    this.#arrived = arrived;
  }

  /** @param {number} count */
  async want(count) {
    for (; this.#asked < count; this.#asked += 1) {
      const number = this.#asked;
      this.#channel
        .request("picture", { number })
        .then(({ buffers }) => createImageBitmap(new Blob([buffers[0]])))
        .then((image) => {
          this.images[number] = image;
          this.#arrived();
        })
        .catch(() => {}); // what cannot be shown has the colour of its label
    }
  }

  /** Whatever was under way is asked for anew. */
  again() {
    this.#asked = this.images.filter(Boolean).length === this.#asked ? this.#asked : 0;
  }
}
