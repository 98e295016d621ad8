/** The pictures of the leaves, each requested once. */
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
        .catch(() => {}); // a leaf without a readable picture has the colour of its label
    }
  }

  /** Requests pictures that were under way again. */
  again() {
    this.#asked = this.images.filter(Boolean).length === this.#asked ? this.#asked : 0;
  }
}
